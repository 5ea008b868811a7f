"""What two processes of this machine do, against one: the best that any sweep can reach here."""

from __future__ import annotations

from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Final

_SECONDS: Final = 4.0


def arithmetic_ratio() -> float:
    """Additions that two processes do in some seconds, over those of one."""
    return _additions(2) / _additions(1)


def _additions(processes: int) -> float:
    """Of all of them together, in the same seconds."""
    context = get_context("spawn")
    pipes = [context.Pipe() for _ in range(processes)]
    workers = [context.Process(target=_add, args=(far,)) for _, far in pipes]
    for worker in workers:
        worker.start()
    for near, _ in pipes:
        near.recv_bytes()  # it is there
    for near, _ in pipes:
        near.send_bytes(b"go")
    done = sum(int(near.recv_bytes()) for near, _ in pipes)
    for worker in workers:
        worker.join()
    return float(done)


def _add(pipe: Connection) -> None:
    from time import perf_counter

    pipe.send_bytes(b"here")
    pipe.recv_bytes()
    total, until = 0, perf_counter() + _SECONDS
    while perf_counter() < until:
        total += sum(1 for _ in range(10_000))
    pipe.send_bytes(str(total).encode())
