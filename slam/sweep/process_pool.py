"""Runs jobs in processes of this machine, and replaces those that die."""

import json
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import connection, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, Final

from slam.sweep.executor import FinishedJob, LostJob
from slam.sweep.job import Job
from slam.system import leave_terminal

ONE_THREAD: Final = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
"""Environment of a worker: one thread, as there are as many workers as processors, and sums keep their order."""


class ProcessPool:
    """``size`` workers, which run one job after another.

    ``allowed`` is the code that the user allows: see slam/config/section.py.
    """

    def __init__(self, size: int, runs: str, pictures: bool, allowed: Sequence[str] = ()) -> None:
        self._worker_arguments = runs, pictures, tuple(allowed)
        self._workers = [_Worker(*self._worker_arguments) for _ in range(size)]

    @property
    def free(self) -> int:
        """Number of workers without a job."""
        return len(self._workers) - self.busy

    @property
    def busy(self) -> int:
        """Number of workers with a job."""
        return sum(worker.job is not None for worker in self._workers)

    def submit(self, job: Job) -> None:
        """Give the job to a worker without one; a dead worker is replaced."""
        index = next(i for i, worker in enumerate(self._workers) if worker.job is None)
        if not self._workers[index].send(job):
            self._replace(index)
            self._workers[index].send(job)

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        """See Executor."""
        pipes = [worker.pipe for worker in self._workers if worker.job is not None]
        ready = connection.wait(pipes, timeout)
        for index, worker in enumerate(self._workers):
            if worker.pipe in ready and (result := worker.receive()) is not None:
                if isinstance(result, LostJob):
                    self._replace(index)
                yield result

    def close(self) -> None:
        """See Executor."""
        for worker in self._workers:
            worker.kill()

    def _replace(self, index: int) -> None:
        self._workers[index].kill()
        self._workers[index] = _Worker(*self._worker_arguments)


class _Worker:
    """One process and the pipe to it."""

    def __init__(self, runs: str, pictures: bool, allowed: Sequence[str]) -> None:
        self.job: Job | None = None
        self.pipe, far_end = get_context("spawn").Pipe()
        self._process: SpawnProcess = get_context("spawn").Process(
            target=_work, args=(far_end, runs, pictures, allowed), daemon=True
        )
        with environment(ONE_THREAD), main_module_hidden():
            self._process.start()
        far_end.close()  # only the worker holds it, so that its death closes the pipe

    def send(self, job: Job) -> bool:
        """Send a job; return False if the process has died."""
        try:
            self.pipe.send_bytes(job.model_dump_json().encode())
        except OSError:
            return False
        self.job = job
        return True

    def receive(self) -> FinishedJob | LostJob | None:
        """Return the result from the pipe; None without a job."""
        job, self.job = self.job, None
        if job is None:
            return None
        try:
            row = json.loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            self._process.join()
            return LostJob(job, f"the worker died: {_describe_exit(self._process.exitcode)}")
        return LostJob(job, "the run was interrupted") if row is None else FinishedJob(job, row)

    def kill(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _work(pipe: Connection, runs: str, pictures: bool, allowed: Sequence[str]) -> None:
    """Run jobs until the pipe is closed or the driver has died; then stop at once, even in a run."""
    leave_terminal()
    threading.Thread(target=_exit_with_driver, daemon=True).start()
    from slam.sweep.run_job import run_job  # imported by the worker, not by the driver

    while (message := _next(pipe)) is not None:
        row = run_job(Job.model_validate_json(message), runs, pictures, allowed)
        pipe.send_bytes(json.dumps(row).encode())


def _next(pipe: Connection) -> bytes | None:
    try:
        return pipe.recv_bytes()
    except (EOFError, OSError):
        return None


def _exit_with_driver() -> None:
    driver = parent_process()
    assert driver is not None
    driver.join()
    os._exit(1)


def _describe_exit(exitcode: int | None) -> str:
    if exitcode is None or exitcode >= 0:
        return f"exit code {exitcode}"
    return f"killed by {signal.Signals(-exitcode).name}"


@contextmanager
def main_module_hidden() -> Iterator[None]:
    """Hide the user's script, which a new process would otherwise run again."""
    main = sys.modules["__main__"]
    hidden: dict[str, Any] = {name: vars(main).pop(name) for name in ("__file__", "__spec__") if name in vars(main)}
    main.__spec__ = None
    try:
        yield
    finally:
        vars(main).update(hidden)


@contextmanager
def environment(changes: dict[str, str]) -> Iterator[None]:
    """Change the environment for processes that are started in the block."""
    before = {name: os.environ[name] for name in changes if name in os.environ}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name in changes:
            del os.environ[name]
        os.environ.update(before)
