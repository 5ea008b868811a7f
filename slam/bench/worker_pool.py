"""Runs the jobs of a benchmark in processes of their own, which end with the benchmark, however that ends."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from signal import SIGKILL, SIGTERM, signal
from threading import Thread
from types import FrameType
from typing import Any, Final, TypeVar

from slam.console.terminal import Terminal

WORKERS: Final = 2
R = TypeVar("R")


def run_in_workers(
    function: Callable[..., R],
    jobs: Sequence[tuple[Any, ...]],
    description: str,
    console: Terminal,
    workers: int = WORKERS,
) -> list[R]:
    """Return the results of the function for these arguments, in their order.

    A bar shows the number of finished jobs. The first error ends all jobs.
    """
    with _worker_pool(workers) as pool:
        futures = [pool.submit(function, *job) for job in jobs]
        with console.progress() as bar:
            for future in bar.track(_as_completed(futures), len(futures), description=description):
                future.result()  # so that an error is known at once
        return [future.result() for future in futures]


def _as_completed(futures: Iterable["Future[R]"]) -> Iterator["Future[R]"]:
    """Yield each future when it is done.

    It wakes up twice a second: Python delays a signal that arrives just before an endless wait until after that wait.
    """
    waiting = set(futures)
    while waiting:
        done, waiting = wait(waiting, timeout=0.5, return_when=FIRST_COMPLETED)
        yield from done


@contextmanager
def _worker_pool(size: int) -> Iterator[ProcessPoolExecutor]:
    """Run worker processes for the block. If an error or a signal leaves it, they end at once, even in a job.

    Each worker leads a process group, so that Ctrl-C reaches the benchmark alone, and holds one end of a pipe. When the
    other end is closed, or this process is gone, the worker kills its group: itself and everything that its job has
    started. It does so on SIGTERM too, which the executor sends to the other workers as soon as one has ended.
    """
    near_end, far_end = Pipe()
    with near_end, far_end, ProcessPoolExecutor(size, initializer=_join_pool, initargs=(near_end, far_end)) as pool:
        try:
            yield pool
        except BaseException:
            near_end.close()
            raise


def _join_pool(near_end: Connection, far_end: Connection) -> None:
    os.setpgid(0, 0)
    signal(SIGTERM, _kill_group)
    near_end.close()  # the benchmark's alone, so that its death closes the pipe
    Thread(target=_end_with, args=(far_end,), daemon=True).start()


def _end_with(pipe: Connection) -> None:
    with suppress(EOFError, OSError):
        pipe.recv_bytes()
    _kill_group()


def _kill_group(_number: int = SIGTERM, _frame: FrameType | None = None) -> None:
    os.killpg(0, SIGKILL)
