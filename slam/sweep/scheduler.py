"""The loop of a sweep: submit jobs to the executor, store their rows."""

from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import Final

from slam.sweep.executor import Executor, FinishedJob, LostJob
from slam.sweep.job import Job
from slam.sweep.result_rows import failed_row
from slam.sweep.result_store import ResultStore

_POLL_PERIOD: Final = 0.5
"""Seconds to wait for a finished job before the next check."""


class Scheduler:
    """Runs jobs until each has a row; one that fails, or loses its worker, is repeated up to ``retry`` times."""

    def __init__(self, executor: Executor, store: ResultStore, retry: int, show: Callable[[int, int], None]) -> None:
        self._executor, self._store, self._retry, self._show = executor, store, retry, show
        self._again: deque[Job] = deque()
        self._tries: Counter[str] = Counter()
        """Attempts of the submitted jobs without a row, by id."""
        self.done = 0
        """Number of jobs that have a row."""
        self.failed = 0
        """Number of jobs that have a row without a result."""

    def run(self, jobs: Iterable[Job]) -> bool:
        """Run all jobs; return True after Ctrl-C. In any case, ``results.parquet`` has the rows so far."""
        waiting = iter(jobs)
        try:
            while self._submit(waiting):
                for result in self._executor.collect(_POLL_PERIOD):
                    self._handle(result)
                self._show(self.done, self.failed)
            return False
        except KeyboardInterrupt:
            return True
        finally:
            self._store.compact()

    def _submit(self, waiting: Iterable[Job]) -> bool:
        """Submit as many jobs as the executor takes; return False when all are finished."""
        for _ in range(self._executor.free):
            job = self._again.popleft() if self._again else next(iter(waiting), None)
            if job is None:
                break
            self._tries[job.id] += 1
            self._executor.submit(job)
        return self._executor.busy > 0

    def _handle(self, result: FinishedJob | LostJob) -> None:
        """Keep the row, or run the job again."""
        row = result.row if isinstance(result, FinishedJob) else failed_row(result.job, result.reason)
        failed = row["status"] == "failed"
        if failed and self._tries[result.job.id] <= self._retry:
            self._again.append(result.job)
            return
        self._store.add(row | {"tries": self._tries.pop(row["id"])})
        self.done += 1
        self.failed += failed
