"""Runs the jobs of a benchmark in processes of their own, which end with the benchmark, however that ends."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from signal import SIG_DFL, SIGKILL, SIGTERM, signal
from threading import Thread
from typing import Any, Final, TypeVar

from slam.console.terminal import Terminal

WORKERS: Final = 2
R = TypeVar("R")


def run_in_workers(
    function: Callable[..., R], jobs: Sequence[tuple[Any, ...]], description: str, console: Terminal
) -> list[R]:
    """Results of the function for these arguments, in their order; a bar shows how many there are. The first error ends
    all jobs."""
    with worker_pool() as pool:
        futures = [pool.submit(function, *job) for job in jobs]
        with console.progress() as bar:
            for future in bar.track(as_completed(futures), len(futures), description=description):
                future.result()  # so that an error is known at once
        return [future.result() for future in futures]


@contextmanager
def worker_pool(size: int = WORKERS) -> Iterator[ProcessPoolExecutor]:
    """Worker processes for the block. Where an error or a signal leaves it, they end at once, even in a job.

    Each worker leads a process group, so that Ctrl-C is for the benchmark alone, and holds one end of a pipe. When the
    other end is closed, or this process is gone, the worker kills its group: itself and all that its job has started.
    """
    near_end, far_end = Pipe()
    with near_end, far_end, ProcessPoolExecutor(size, initializer=_join_pool, initargs=(near_end, far_end)) as pool:
        try:
            yield pool
        except BaseException:
            near_end.close()
            raise


def _join_pool(near_end: Connection, far_end: Connection) -> None:
    signal(SIGTERM, SIG_DFL)  # what the benchmark has to end in order is not here
    os.setpgid(0, 0)
    near_end.close()  # the benchmark's alone, so that its death closes the pipe
    Thread(target=_end_with, args=(far_end,), daemon=True).start()


def _end_with(pipe: Connection) -> None:
    with suppress(EOFError, OSError):
        pipe.recv_bytes()
    os.killpg(0, SIGKILL)
