"""Benchmarks sim and env: the same drive of the simulated robot, and of the drivers on emulated devices."""

from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Any, Final

import numpy as np

from hardware.bench.driven_path import DrivenPath, PathRecorder
from hardware.bench.emulated_robot import emulated_devices
from hardware.bench.policy import GoalPolicy
from hardware.emulator.emulator import Emulator
from slam.console.terminal import Terminal
from slam.env.p3dx_env import P3DXEnv
from slam.line_slam import Estimate
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.experiment import Experiment
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import run_loop
from slam.run.step import Step, Watcher
from slam.run.warm_up import warm_up
from slam.run.watchers import Interruption, RunProgress
from slam.scenario.schema import Scenario
from slam.scenario.values import Point

LoadScenario = Callable[[Sequence[str]], Scenario]
"""Loads the scenario with these settings."""
_BRAKING: Final = 15
"""Steps after the end in which no motion is commanded, so that the robot comes to rest."""


def drive_simulated(load: LoadScenario, settings: Sequence[str], console: Terminal) -> DrivenPath:
    """Drive the simulated robot."""
    return _run(scenario_experiment(load(settings)), PathRecorder(), console, "sim")


def drive_emulated(load: LoadScenario, settings: Sequence[str], console: Terminal) -> DrivenPath:
    """Drive devices emulated at two pseudo-terminals, in real time."""
    with emulated_devices(load(settings)) as emulator, emulator:
        scenario = load([*settings, *emulator.port_settings])
        return _run(scenario_experiment(scenario, "hardware", yes=True), PathRecorder(emulator), console, "hardware")


def _run(experiment: Experiment, recorder: PathRecorder, console: Terminal, name: str) -> DrivenPath:
    warm_up(console, experiment.scenario.slam)
    progress = RunProgress(console, f"{experiment.scenario.name}, {name}")
    with closing(experiment.env), progress as bar, Interruption() as interruption:
        watchers: list[Watcher] = [recorder, bar, interruption]
        run_loop(experiment.env, experiment.slam, experiment.pilot, watchers, experiment.seed)
        return recorder.path(experiment.env.robot)


def drive_env_simulated(load: LoadScenario, settings: Sequence[str], goal: Point) -> DrivenPath:
    """Drive the simulated robot, which is given the true direction of the goal, x and y in the map frame."""
    return _run_episode(P3DXEnv(load(settings), observe="goal"), goal, None)


def drive_env_emulated(load: LoadScenario, settings: Sequence[str], goal: Point, plant: str) -> DrivenPath:
    """Drive emulated devices, moved by this plant, in real time; SLAM gives them the direction of the goal."""
    with emulated_devices(load(settings), plant=plant) as emulator, emulator:
        scenario = load([*settings, *emulator.port_settings])
        return _run_episode(P3DXEnv(scenario, observe="goal", backend="hardware", yes=True), goal, emulator)


def _run_episode(env: P3DXEnv, goal: Point, emulator: Emulator | None) -> DrivenPath:
    """Run one episode to its end, and then until the robot is at rest."""
    recorder, policy = PathRecorder(emulator), GoalPolicy()
    with closing(env):
        observation, info = env.reset(seed=env.scenario.seed, options={"goal": goal})
        recorder.on_step(_step(info))
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(policy(observation))
            recorder.on_step(_step(info))
            over = terminated or truncated
        for _ in range(_BRAKING):
            *_, info = env.step(np.zeros(2))
            recorder.on_step(_step(info))
        return recorder.path(env.robot)


def _step(info: dict[str, Any]) -> Step:
    observation = info["observation"]
    return Step(0, observation, Estimate(observation.scan.stamp, Pose2D.from_array(info["pose"])), Twist2D(), 0.0)
