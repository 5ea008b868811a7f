"""The progress bar of a sweep."""

from __future__ import annotations

from time import perf_counter
from types import TracebackType
from typing import Self

from slam.console.terminal import Terminal


class SweepProgress:
    """Runs done and failed, runs a second, and the time that is left."""

    def __init__(self, console: Terminal, name: str, total: int) -> None:
        self._bar = console.progress(
            "{task.completed}/{task.total} runs", "{task.fields[failed]} failed", "{task.fields[rate]}"
        )
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
