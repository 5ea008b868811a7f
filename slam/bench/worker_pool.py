"""Runs the jobs of a benchmark in separate processes, which always end with the benchmark."""

import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Thread
from types import FrameType
from typing import Any, Final, TypeVar

from slam.console.terminal import Terminal
from slam.system import leave_terminal

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
    """Run worker processes while the block runs.

    If an exception or a signal ends the block, the workers are killed at once, even during a job.

    Each worker leads a session, so that Ctrl-C reaches the benchmark alone, and holds one end of a pipe. When the
    other end is closed, or this process is gone, the worker kills its group: itself and everything that its job has
    started. It does so on SIGTERM too, which the executor sends to the other workers as soon as one has ended.
    """
    ends: tuple[Any, Any] = Pipe()  # Any: the class of a pipe end depends on the operating system
    near_end, far_end = ends
    with near_end, far_end, ProcessPoolExecutor(size, initializer=_join_pool, initargs=(near_end, far_end)) as pool:
        try:
            yield pool
        except BaseException:
            near_end.close()
            raise


def _join_pool(near_end: Connection, far_end: Connection) -> None:
    leave_terminal()
    signal.signal(signal.SIGTERM, _kill_group)
    near_end.close()  # only the benchmark process keeps this end open, so that the pipe closes when it dies
    Thread(target=_end_with, args=(far_end,), daemon=True).start()


def _end_with(pipe: Connection) -> None:
    with suppress(EOFError, OSError):
        pipe.recv_bytes()
    _kill_group()


def _kill_group(_number: int = signal.SIGTERM, _frame: FrameType | None = None) -> None:
    if sys.platform != "win32":
        os.killpg(0, signal.SIGKILL)
    os._exit(1)  # Windows has no process groups; child processes of a job exit when their standard input closes
