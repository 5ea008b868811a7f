"""The progress bar of a sweep."""

from __future__ import annotations

from time import perf_counter
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


class SweepProgress:
    """Runs done and failed, runs a second, and the time that is left."""

    def __init__(self, console: Console, name: str, total: int) -> None:
        columns = (
            TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed}/{task.total} runs"),
            TextColumn("{task.fields[failed]} failed"), TextColumn("{task.fields[rate]}"), TimeElapsedColumn(),
            TextColumn("left"), TimeRemainingColumn(),
        )  # fmt: skip
        self._bar = Progress(*columns, console=console, refresh_per_second=2, speed_estimate_period=300)
        self._task = self._bar.add_task(name, total=total, failed=0, rate="")
        self._began = perf_counter()

    def show(self, done: int, failed: int) -> None:
        """So many runs are over, ``failed`` of them without a result."""
        rate = f"{done / max(perf_counter() - self._began, 1e-9):.2f} runs/s"
        self._bar.update(self._task, completed=done, failed=failed, rate=rate)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, tb: TracebackType | None
    ) -> None:
        self._bar.stop()
