"""Cost of a sweep itself: runs per second by the number of jobs, the driver's share, its memory."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Final

from slam.sweep.executor import Executor, FinishedJob, LostJob
from slam.sweep.folder import Folder
from slam.sweep.job import Job
from slam.sweep.make_plan import make_plan
from slam.sweep.result_rows import job_columns
from slam.sweep.result_store import ResultStore
from slam.sweep.scheduler import Scheduler
from slam.system import peak_memory

_ADDING_TIME: Final = 4.0
"""Simulated seconds per run."""


@dataclass(frozen=True, slots=True)
class SweepSpeed:
    """Speed of a warm executor with some number of jobs at a time."""

    rate: float
    """Runs per second."""
    driver: float
    """Share of one core that the driver uses."""
    overhead: float
    """Seconds that a run costs a worker in addition to the drive."""


def sweep_speed(make: Callable[[str, int], Executor], at_a_time: int, runs: int) -> SweepSpeed:
    """Measure the executor that ``make`` returns for the URL of the runs and a number of jobs."""
    with TemporaryDirectory() as here, closing(make(f"{here}/runs", at_a_time)) as executor:
        jobs, store = _jobs(runs + at_a_time, duration=30.0), ResultStore(Folder(here))
        _warm(executor, list(islice(jobs, at_a_time)))
        began, cpu = perf_counter(), process_time()
        Scheduler(executor, store, retry=0, show=lambda done, failed: None).run(jobs)
        elapsed, used = perf_counter() - began, process_time() - cpu
        driving = [row["duration_s"] / row["wall.real_time_factor"] for row in store.rows()]
    return SweepSpeed(runs / elapsed, used / elapsed, (at_a_time * elapsed - sum(driving)) / runs)


def memory_of_rows(count: int) -> float:
    """Return the peak memory of this process, megabytes, after ``count`` artificial rows."""
    with TemporaryDirectory() as here:
        store = ResultStore(Folder(here))
        Scheduler(_FakeExecutor(), store, retry=0, show=lambda done, failed: None).run(_jobs(count, duration=1.0))
        assert len(store.done()) == count
    return 1e-6 * peak_memory()


def arithmetic_ratio() -> float:
    """Return how many times as many additions two processes do as one: no sweep can speed up more on this machine."""
    return _additions(2) / _additions(1)


class _FakeExecutor:
    """Executor that makes artificial rows, as wide as real ones."""

    def __init__(self) -> None:
        self._jobs: deque[Job] = deque()

    @property
    def free(self) -> int:
        return 2 - len(self._jobs)

    @property
    def busy(self) -> int:
        return len(self._jobs)

    def submit(self, job: Job) -> None:
        self._jobs.append(job)

    def collect(self, timeout: float) -> Iterator[FinishedJob | LostJob]:
        job = self._jobs.popleft()
        metrics = {f"metric_{index}": job.seed + index / 7 for index in range(40)}
        curve = {"error_m": [job.seed / 7] * 64}
        yield FinishedJob(job, job_columns(job) | {"status": "done", "error": None} | metrics | curve)

    def close(self) -> None:
        self._jobs.clear()


def _jobs(count: int, duration: float) -> Iterator[Job]:
    """Make jobs of the paper's world with this project's method, at most this number of simulated seconds long."""
    changes = {"seeds": f"0:{count}", "modes": ["hopslam"], "settings": {"duration": duration}}
    return make_plan(["paper_simulation"], changes).jobs()


def _warm(executor: Executor, jobs: list[Job]) -> None:
    """Finish a first run in each worker, which loads what runs need."""
    for job in jobs:
        executor.submit(job)
    while executor.busy:
        list(executor.collect(1.0))


def _additions(processes: int) -> float:
    """Count the additions of all processes together, in the same seconds."""
    context = get_context("spawn")
    pipes = [context.Pipe() for _ in range(processes)]
    workers = [context.Process(target=_add, args=(far,)) for _, far in pipes]
    for worker in workers:
        worker.start()
    for near, _ in pipes:
        near.recv_bytes()  # it has started
    for near, _ in pipes:
        near.send_bytes(b"go")
    done = sum(int(near.recv_bytes()) for near, _ in pipes)
    for worker in workers:
        worker.join()
    return float(done)


def _add(pipe: Connection) -> None:
    pipe.send_bytes(b"here")
    pipe.recv_bytes()
    total, until = 0, perf_counter() + _ADDING_TIME
    while perf_counter() < until:
        total += sum(1 for _ in range(10_000))
    pipe.send_bytes(str(total).encode())
