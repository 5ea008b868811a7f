"""The progress bar of a run."""

from __future__ import annotations

from time import perf_counter
from typing import Self

from slam.console.terminal import Terminal
from slam.pose import Pose2D
from slam.run.step import Step


class RunProgress:
    """A watcher that shows how far the run is, its scan rate, and its present error where the truth is known."""

    def __init__(self, console: Terminal, name: str) -> None:
        self._bar = console.progress(
            "{task.percentage:>3.0f}%", "{task.fields[scans]} scans", "{task.fields[rate]}", "{task.fields[error]}"
        )
        self._task = self._bar.add_task(name, total=1.0, scans=0, rate="", error="")
        self._began = perf_counter()

    def see(self, step: Step) -> None:
        """Show one step."""
        scans = step.index + 1
        rate = f"{scans / max(perf_counter() - self._began, 1e-9):.0f}/s"
        self._bar.update(self._task, completed=step.progress, scans=scans, rate=rate, error=_error(step))

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()


def _error(step: Step) -> str:
    truth = step.observation.T_map_base
    if truth is None:
        return ""
    error: Pose2D = truth.between(step.estimate.T_map_base)
    return f"error {100 * error.distance(Pose2D()):.1f} cm"
