"""Runs jobs in processes of this machine, and replaces those that die."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import connection, get_context
from multiprocessing.context import SpawnProcess
from typing import Final

from slam.run.results.keep import Keep
from slam.sweep.executor import Finished, Lost
from slam.sweep.job import Job
from slam.sweep.worker import work

ONE_THREAD: Final = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
"""The environment of a worker: there are as many of them as processors, and the same sums in the same order."""


class Pool:
    """``size`` workers, which stay warm from job to job; each has one job at a time.

    ``allowed`` is the code that the user allows: see slam/config/section.py.
    """

    def __init__(self, size: int, runs: str, keep: Keep, allowed: Sequence[str] = ()) -> None:
        self._made_with = runs, keep, tuple(allowed)
        self._workers = [_Worker(*self._made_with) for _ in range(size)]

    @property
    def free(self) -> int:
        """Workers without a job."""
        return len(self._workers) - self.busy

    @property
    def busy(self) -> int:
        """Workers with one."""
        return sum(worker.job is not None for worker in self._workers)

    @property
    def pids(self) -> list[int]:
        """Process ids of the workers."""
        return [worker.pid for worker in self._workers]

    def submit(self, job: Job) -> None:
        """Give it to a worker without one; a dead one is replaced."""
        index = next(i for i, worker in enumerate(self._workers) if worker.job is None)
        if not self._workers[index].take(job):
            self._replace(index)
            self._workers[index].take(job)

    def collect(self, timeout: float) -> Iterator[Finished | Lost]:
        """See Executor."""
        pipes = [worker.pipe for worker in self._workers if worker.job is not None]
        ready = connection.wait(pipes, timeout)
        for index, worker in enumerate(self._workers):
            if worker.pipe in ready and (came := worker.give()) is not None:
                if isinstance(came, Lost):
                    self._replace(index)
                yield came

    def close(self) -> None:
        """See Executor."""
        for worker in self._workers:
            worker.kill()

    def _replace(self, index: int) -> None:
        self._workers[index].kill()
        self._workers[index] = _Worker(*self._made_with)


class _Worker:
    """One process and the pipe to it."""

    def __init__(self, runs: str, keep: Keep, allowed: Sequence[str]) -> None:
        self.job: Job | None = None
        self.pipe, far_end = get_context("spawn").Pipe()
        self._process: SpawnProcess = get_context("spawn").Process(
            target=work, args=(far_end, os.getpid(), runs, keep, allowed), daemon=True
        )
        with _environment(ONE_THREAD):
            self._process.start()
        far_end.close()  # the worker's alone, so that its death closes the pipe

    @property
    def pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    def take(self, job: Job) -> bool:
        """False where the process is gone."""
        try:
            self.pipe.send_bytes(job.model_dump_json().encode())
        except OSError:
            return False
        self.job = job
        return True

    def give(self) -> Finished | Lost | None:
        """What came through the pipe; None where there was no job."""
        job, self.job = self.job, None
        if job is None:
            return None
        try:
            row = json.loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            self._process.join()
            return Lost(job, f"the worker died: {_death(self._process.exitcode)}")
        return Lost(job, "the run was interrupted") if row is None else Finished(job, row)

    def kill(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _death(exitcode: int | None) -> str:
    if exitcode is None or exitcode >= 0:
        return f"exit code {exitcode}"
    return f"killed by {signal.Signals(-exitcode).name}"


@contextmanager
def _environment(changes: dict[str, str]) -> Iterator[None]:
    """For processes that are started in the block."""
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
