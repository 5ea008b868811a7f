"""Benchmark sim: the same scenario driven by the simulated robot, and by the drivers on emulated devices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from hardware.bench.emulated_robot import emulated_devices, port_settings
from hardware.emulator.emulator import Emulator
from hardware.robot import HardwareRobot
from slam.console.terminal import Terminal
from slam.pose import FloatArray, Pose2D
from slam.run.experiment import Experiment, scenario_experiment
from slam.run.interruption import Interruption
from slam.run.loop import run_loop
from slam.run.results.progress import RunProgress
from slam.run.step import Step, Watcher
from slam.run.warm_up import warm_up
from slam.scenario.schema import Scenario

LoadScenario = Callable[[Sequence[str]], Scenario]
"""Loads the scenario with these settings."""


@dataclass(frozen=True, slots=True, eq=False)
class DrivenPath:
    """The path of one run, scan by scan; poses are rows x, y, theta of ``T_map_base``, (N, 3)."""

    truth: FloatArray
    estimate: FloatArray

    @property
    def errors(self) -> FloatArray:
        """Metres between the estimate and the truth, (N,), without alignment, as both begin at the same place."""
        errors: FloatArray = np.hypot(*(self.estimate - self.truth)[:, :2].T)
        return errors


@dataclass
class PathRecorder:
    """A watcher that keeps estimated and true poses: the truth at the scan, or that of now where only it is known."""

    emulator: Emulator | None = None
    stamps: list[float] = field(default_factory=list)
    estimate: list[Pose2D] = field(default_factory=list)
    truth: list[tuple[float, Pose2D]] = field(default_factory=list)

    def see(self, step: Step) -> None:
        observation = step.observation
        self.stamps.append(observation.scan.stamp)
        self.estimate.append(step.estimate.T_map_base)
        if self.emulator is not None:
            self.truth.append(self.emulator.truth)
        elif observation.T_map_base is not None:
            self.truth.append((observation.scan.stamp, observation.T_map_base))

    def path(self, epoch: float) -> DrivenPath:
        """Return the path, with the truth at the scans' stamps, which count from ``epoch`` on the truth's clock."""
        known = np.array([stamp for stamp, _ in self.truth]) - epoch
        x, y, theta = _rows([pose for _, pose in self.truth]).T
        truth = [np.interp(self.stamps, known, column) for column in (x, y, np.unwrap(theta))]
        return DrivenPath(np.column_stack(truth), _rows(self.estimate))


def drive_simulated(load: LoadScenario, settings: Sequence[str], console: Terminal) -> DrivenPath:
    """Drive the simulated robot."""
    return _drive(scenario_experiment(load(settings)), PathRecorder(), console, "sim")


def drive_emulated(load: LoadScenario, settings: Sequence[str], console: Terminal) -> DrivenPath:
    """Drive devices emulated at two pseudo-terminals, in real time."""
    with emulated_devices(load(settings)) as emulator, emulator:
        scenario = load([*settings, *port_settings(emulator)])
        return _drive(scenario_experiment(scenario, "hardware", yes=True), PathRecorder(emulator), console, "hardware")


def _drive(experiment: Experiment, recorder: PathRecorder, console: Terminal, name: str) -> DrivenPath:
    warm_up(console, experiment.scenario.slam)
    with ExitStack() as stack:
        stack.callback(experiment.env.close)
        bar = stack.enter_context(RunProgress(console, f"{experiment.scenario.name}, {name}"))
        watchers: list[Watcher] = [recorder, bar, stack.enter_context(Interruption())]
        run_loop(experiment.env, experiment.slam, experiment.pilot, watchers, experiment.seed)
        robot = experiment.env.robot
        return recorder.path((robot.epoch or 0.0) if isinstance(robot, HardwareRobot) else 0.0)


def _rows(poses: Sequence[Pose2D]) -> FloatArray:
    return np.array([(pose.x, pose.y, pose.theta) for pose in poses])
