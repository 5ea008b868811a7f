"""The loop of every run: observe, estimate, decide, drive."""

from collections.abc import Callable, Iterable
from math import inf
from time import monotonic
from typing import Final, Literal, TypeVar

import numpy as np

from slam.errors import RobotTimeout
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.run.estimator import Estimator
from slam.run.pilots import Pilot
from slam.run.robot_env import RobotEnv
from slam.run.step import Step, Watcher

Ending = Literal["arrived", "collided", "duration over", "no more scans", "interrupted", "battery empty", "failed"]
"""Reason why a run ended, for ``metrics.json``. Until 0.1 ``no more scans`` also meant ``duration over``."""
_NO_TIME: Final = 2.5
"""If scans stop when less time than this is left, in times of a scan, the run ended because its duration is over."""
Taken = TypeVar("Taken")


def run_loop(
    env: RobotEnv,
    slam: Estimator,
    pilot: Pilot,
    watchers: Iterable[Watcher],
    seed: int | None,
    patience: float = 0.0,
    duration: float = inf,
    told_to_end: Callable[[], bool] = lambda: False,
) -> Ending:
    """Drive until the pilot has arrived, the robot has hit something, or there are no more scans.

    The robot gives no more scans after ``duration``, seconds, or earlier, as at the end of a log.

    A robot that falls silent has ``patience`` seconds to come back; RobotTimeout after that, or once the program is
    ``told_to_end``.
    """
    _, info = env.reset(seed=seed)
    applied, index, timeouts = Twist2D(), 0, 0
    began = info["observation"].scan.stamp
    while True:
        observation: Observation = info["observation"]
        estimate = slam.update(observation.scan, observation.odometry)
        command = pilot.command(estimate.T_map_base, observation.scan)
        for watcher in watchers:
            watcher.on_step(Step(index, observation, estimate, applied, pilot.progress, timeouts))
        if observation.collided:
            return "collided"
        if command is None:
            return "arrived"
        (*_, truncated, info), timeouts = step_patiently(
            lambda twist: env.step(np.array([twist.linear, twist.angular], np.float32)), command, patience, told_to_end
        )
        if truncated:
            left = began + duration - observation.scan.stamp
            return "duration over" if left < _NO_TIME * observation.scan.scan_time else "no more scans"
        applied, index = info["applied"], index + 1


def step_patiently(
    step: Callable[[Twist2D], Taken],
    command: Twist2D,
    patience: float,
    told_to_end: Callable[[], bool] = lambda: False,
) -> tuple[Taken, int]:
    """Make a step, which drives until the next scan; if none comes, stop and wait for one.

    Returns the result of the step, and how often the robot was silent for too long. RobotTimeout after ``patience``
    seconds, or once the program is ``told_to_end``.
    """
    until, timeouts = monotonic() + patience, 0
    while True:
        try:
            return step(command), timeouts
        except RobotTimeout:
            if monotonic() >= until or told_to_end():
                raise
            command, timeouts = Twist2D(), timeouts + 1
