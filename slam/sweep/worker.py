"""A process of the pool: takes jobs from a pipe, gives rows back."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Final

from slam.sweep.job import Job

_EVERY: Final = 1.0
"""Seconds between two looks at whether the driver still lives."""


def work(pipe: Connection, driver: int, runs: str, pictures: bool, allowed: Sequence[str]) -> None:
    """Until the pipe is closed, or the driver (its process id) is gone: then at once, in the middle of a run too."""
    os.setsid()  # Ctrl-C is for the driver, which then ends its workers
    threading.Thread(target=_leave_with, args=(driver,), daemon=True).start()
    from slam.sweep.run_job import run_job  # here, so that the time it takes is the worker's

    while (message := _next(pipe)) is not None:
        row = run_job(Job.model_validate_json(message), runs, pictures, allowed)
        pipe.send_bytes(json.dumps(row).encode())


def _next(pipe: Connection) -> bytes | None:
    try:
        return pipe.recv_bytes()
    except (EOFError, OSError):
        return None


def _leave_with(driver: int) -> None:
    while os.getppid() == driver:
        time.sleep(_EVERY)
    os._exit(1)
