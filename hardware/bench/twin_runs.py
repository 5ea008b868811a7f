"""The same scenario driven twice: by the simulated robot, and by the drivers on emulated devices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from hardware.bench.bench import emulated, port_settings
from hardware.emulator.emulator import Emulator
from hardware.robot import HardwareRobot
from slam.console.terminal import Terminal
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.experiment import Experiment, scenario_experiment
from slam.run.interruption import Interruption
from slam.run.loop import run_loop
from slam.run.results.progress import RunProgress
from slam.run.step import Step, Watcher
from slam.run.warm_up import warm_up
from slam.scenario.schema import Scenario

Load = Callable[[Sequence[str]], Scenario]
"""The scenario with these settings."""


@dataclass(frozen=True, slots=True, eq=False)
class DrivenWay:
    """One run, scan by scan; poses are rows x, y, theta of ``T_map_base``, (N, 3)."""

    truth: FloatArray
    estimate: FloatArray

    @property
    def errors(self) -> FloatArray:
        """Metres between the estimate and the truth, (N,); without alignment, as both begin at the same place."""
        errors: FloatArray = np.hypot(*(self.estimate - self.truth)[:, :2].T)
        return errors


@dataclass
class WayNotes:
    """A watcher that keeps what is estimated, and what is true: at the scan, or about now where only that is known."""

    emulator: Emulator | None = None
    stamps: list[float] = field(default_factory=list)
    estimate: list[Pose2D] = field(default_factory=list)
    truth: list[tuple[float, Pose2D]] = field(default_factory=list)

    def see(self, step: Step) -> None:
        seen = step.observation
        self.stamps.append(seen.scan.stamp)
        self.estimate.append(step.estimate.T_map_base)
        if self.emulator is not None:
            self.truth.append(self.emulator.truth)
        elif seen.T_map_base is not None:
            self.truth.append((seen.scan.stamp, seen.T_map_base))

    def way(self, epoch: float) -> DrivenWay:
        """With the truth at the scans' stamps, which count from ``epoch`` on the clock of the truth."""
        known = np.array([stamp for stamp, _ in self.truth]) - epoch
        x, y, theta = stack_poses([pose for _, pose in self.truth]).T
        truth = [np.interp(self.stamps, known, column) for column in (x, y, np.unwrap(theta))]
        return DrivenWay(np.column_stack(truth), stack_poses(self.estimate))


def simulated_way(load: Load, settings: Sequence[str], console: Terminal) -> DrivenWay:
    """On the simulated robot."""
    return _drive(scenario_experiment(load(settings)), WayNotes(), console, "sim")


def emulated_way(load: Load, settings: Sequence[str], console: Terminal) -> DrivenWay:
    """On devices emulated at two pseudo-terminals, in real time."""
    with emulated(load(settings)) as emulator, emulator:
        scenario = load([*settings, *port_settings(emulator)])
        return _drive(scenario_experiment(scenario, "hardware", yes=True), WayNotes(emulator), console, "hardware")


def _drive(experiment: Experiment, notes: WayNotes, console: Terminal, name: str) -> DrivenWay:
    warm_up(console, experiment.scenario.slam)
    with ExitStack() as stack:
        stack.callback(experiment.env.close)
        bar = stack.enter_context(RunProgress(console, f"{experiment.scenario.name}, {name}"))
        watchers: list[Watcher] = [notes, bar, stack.enter_context(Interruption())]
        run_loop(experiment.env, experiment.slam, experiment.pilot, watchers, experiment.seed)
        robot = experiment.env.robot
        return notes.way((robot.epoch or 0.0) if isinstance(robot, HardwareRobot) else 0.0)
