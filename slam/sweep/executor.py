"""Interface of the executors of a sweep's jobs: processes of this machine, or a cluster."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from slam.sweep.job import Job
from slam.sweep.result_rows import Row


@dataclass(frozen=True, slots=True)
class FinishedJob:
    """A finished job, with its row."""

    job: Job
    row: Row


@dataclass(frozen=True, slots=True)
class LostJob:
    """A job whose worker died or was interrupted."""

    job: Job
    reason: str


class Executor(Protocol):
    """Runs jobs in other processes."""

    @property
    def free(self) -> int:
        """Number of jobs that can be submitted now."""

    @property
    def busy(self) -> int:
        """Number of submitted jobs that have not finished."""

    def submit(self, job: Job) -> None:
        """Start a job."""

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        """Yield finished jobs, after waiting for at most ``timeout`` seconds; a lost one may be submitted again."""

    def close(self) -> None:
        """Stop at once; unfinished jobs are dropped."""
