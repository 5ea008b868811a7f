"""What a sweep asks of whoever runs its jobs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from slam.sweep.job import Job
from slam.sweep.row import Row


@dataclass(frozen=True, slots=True)
class Finished:
    """A job that came back, with its row."""

    job: Job
    row: Row


@dataclass(frozen=True, slots=True)
class Lost:
    """A job whose worker went away under it."""

    job: Job
    reason: str


class Executor(Protocol):
    """Runs jobs in other processes."""

    @property
    def free(self) -> int:
        """How many more jobs it takes now."""
        ...

    @property
    def busy(self) -> int:
        """How many jobs it has that did not come back."""
        ...

    def submit(self, job: Job) -> None:
        """Take a job."""
        ...

    def collect(self, timeout: float) -> Iterator[Finished | Lost]:
        """What came back, after waiting for at most ``timeout`` seconds; a lost job is free to be submitted again."""
        ...

    def close(self) -> None:
        """Stop at once; jobs that did not come back are dropped."""
        ...
