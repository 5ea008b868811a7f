"""The loop of a sweep: jobs to the executor, rows to the store."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import Final

from slam.sweep.executor import Executor, Finished, Lost
from slam.sweep.job import Job
from slam.sweep.row import Row, failed
from slam.sweep.store import SweepStore

_LOOK_EVERY: Final = 0.5
"""Seconds."""


class Driver:
    """Runs jobs until each has a row; one that fails, or loses its worker, is tried ``retry`` times more."""

    def __init__(self, executor: Executor, store: SweepStore, retry: int, show: Callable[[int, int], None]) -> None:
        self._executor, self._store, self._retry, self._show = executor, store, retry, show
        self._again: deque[Job] = deque()
        self._tries: Counter[str] = Counter()
        """Of the jobs that were given away and have no row."""
        self.done = 0
        """Jobs that have a row ..."""
        self.failed = 0
        """... and those of them without a result."""

    def run(self, jobs: Iterable[Job]) -> bool:
        """All of them; whether Ctrl-C came first. However it ends, ``results.parquet`` has the rows that are there."""
        waiting = iter(jobs)
        try:
            while self._feed(waiting):
                for came in self._executor.collect(_LOOK_EVERY):
                    self._take(came)
                self._show(self.done, self.failed)
            return False
        except KeyboardInterrupt:
            return True
        finally:
            self._store.compact()

    def _feed(self, waiting: Iterable[Job]) -> bool:
        """Give away as many jobs as are taken; False when all are over."""
        for _ in range(self._executor.free):
            job = self._again.popleft() if self._again else next(iter(waiting), None)
            if job is None:
                break
            self._tries[job.id] += 1
            self._executor.submit(job)
        return self._executor.busy > 0

    def _take(self, came: Finished | Lost) -> None:
        row = came.row if isinstance(came, Finished) else failed(came.job, came.reason)
        if row["status"] == "failed" and self._tries[came.job.id] <= self._retry:
            self._again.append(came.job)
        else:
            self._keep(row)

    def _keep(self, row: Row) -> None:
        self._store.add(row | {"tries": self._tries.pop(row["id"])})
        self.done += 1
        self.failed += row["status"] == "failed"
