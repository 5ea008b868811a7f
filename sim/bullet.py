"""One PyBullet client: every call names its client, and every PyBullet error becomes a RobotError."""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from slam.errors import RobotError


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Drop what C code writes to standard error, which Python cannot redirect."""
    stderr = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(nowhere)
        os.close(stderr)


with _silent_stderr():  # its import prints its build time
    import pybullet

__all__ = ["Bullet", "pybullet"]


class Bullet:
    """A physics server in this process. Close it: PyBullet crashes after some 800 that are left open."""

    def __init__(self) -> None:
        self._client: int = pybullet.connect(pybullet.DIRECT)
        if self._client < 0:
            raise RobotError("PyBullet gave no client; close simulated robots that are no longer used")
        self._disconnect = weakref.finalize(self, pybullet.disconnect, physicsClientId=self._client)

    @property
    def closed(self) -> bool:
        """Whether ``close`` was called."""
        return not self._disconnect.alive

    def close(self) -> None:
        """Free the server; closing twice is allowed."""
        self._disconnect()
        self._client = -1  # PyBullet gives the old number to the next client

    def call(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """``function(*args, **kwargs)`` of the pybullet module, in this client."""
        try:
            return function(*args, **kwargs, physicsClientId=self._client)
        except pybullet.error as error:
            state = "the simulated world is closed" if self.closed else "PyBullet refused"
            raise RobotError(f"{state}: {function.__name__}: {error}") from error
