"""One policy in the learning environment, simulated and on emulated devices."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hardware.bench.bench import emulated, port_settings
from hardware.bench.twin_runs import DrivenWay, Load, WayNotes
from hardware.emulator.emulator import Emulator
from hardware.robot import HardwareRobot
from slam.env.p3dx_env import P3DXEnv
from slam.line_slam import Estimate
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.step import Step
from slam.scenario.values import Point

_SPEED, _TURN_SPEED = 0.5, 0.8
"""Largest speeds that the policy asks for, m/s and rad/s."""
_BRAKING: Final = 15
"""Steps after the end in which no motion is commanded, so that the robot comes to rest."""


def simulated_env_way(load: Load, settings: Sequence[str], goal: Point) -> DrivenWay:
    """Drive the simulated robot, which is told the true way to the goal, x and y in the map frame."""
    return _drive(P3DXEnv(load(settings), observe="goal"), goal, None)


def emulated_env_way(load: Load, settings: Sequence[str], goal: Point, plant: str) -> DrivenWay:
    """Drive emulated devices that this plant moves, in real time; SLAM tells them the way to the goal."""
    with emulated(load(settings), plant=plant) as emulator, emulator:
        scenario = load([*settings, *port_settings(emulator)])
        return _drive(P3DXEnv(scenario, observe="goal", backend="hardware", yes=True), goal, emulator)


def to_the_goal(observation: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    """A policy: turn towards the next way-point, and slow down before it."""
    distance, bearing = observation["goal"]
    v = np.clip(distance - 0.1, 0.05, _SPEED) * max(np.cos(bearing), 0.0)
    return np.array([v, np.clip(1.5 * bearing, -_TURN_SPEED, _TURN_SPEED)], np.float32)


def _drive(env: P3DXEnv, goal: Point, emulator: Emulator | None) -> DrivenWay:
    """One episode until its end, and then until the robot stands."""
    notes = WayNotes(emulator)
    with closing(env):
        observation, info = env.reset(seed=env.scenario.seed, options={"goal": goal})
        notes.see(_step(info))
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(to_the_goal(observation))
            notes.see(_step(info))
            over = terminated or truncated
        for _ in range(_BRAKING):
            *_, info = env.step(np.zeros(2))
            notes.see(_step(info))
        return notes.way((env.robot.epoch or 0.0) if isinstance(env.robot, HardwareRobot) else 0.0)


def _step(info: dict[str, Any]) -> Step:
    observation = info["observation"]
    return Step(0, observation, Estimate(observation.scan.stamp, Pose2D.from_array(info["pose"])), Twist2D(), 0.0)
