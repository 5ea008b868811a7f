"""One PyBullet client: every call names its client, and every PyBullet error becomes a RobotError."""

import os
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from slam.errors import RobotError


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Suppress what C code writes to standard error, which Python cannot redirect."""
    stderr = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(nowhere)
        os.close(stderr)


try:
    with _silent_stderr():  # its import prints its build time
        import pybullet
except ModuleNotFoundError as error:
    raise RobotError(
        "PyBullet is not installed; it has wheels for CPython 3.11 on Linux x86-64: take that, or build it with a "
        "compiler: pip install pybullet. The kinematic model needs none: --set physics.engine=plan; nor do logs: "
        "hopslam replay LOG"
    ) from error

__all__ = ["Bullet", "pybullet"]


_idle: list[int] = []
"""A closed server, empty and ready for the next world: a new one costs up to 20 ms, emptying it 0.3 ms."""


def _take_server() -> int:
    client: int = _idle.pop() if _idle else pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise RobotError("PyBullet gave no client; close simulated robots that are no longer used")
    return client


def _give_back(client: int) -> None:
    if _idle:
        pybullet.disconnect(physicsClientId=client)
    else:
        pybullet.resetSimulation(physicsClientId=client)
        _idle.append(client)


class Bullet:
    """A physics server in this process. Close it: PyBullet crashes after about 800 that are left open."""

    def __init__(self) -> None:
        self._client = _take_server()
        self._release = weakref.finalize(self, _give_back, self._client)

    @property
    def closed(self) -> bool:
        """True after ``close``."""
        return self._client < 0

    def close(self) -> None:
        """Free the server; closing twice is allowed."""
        self._release()
        self._client = -1  # the next world gets the old number

    def call(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """Call ``function(*args, **kwargs)`` of the pybullet module in this client."""
        return self.prepared(function, *args, **kwargs)()

    def prepared(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[[], Any]:
        """Return the same call as a function, for frequent use: binding costs more than calling."""
        ready = partial(function, *args, **kwargs, physicsClientId=self._client)

        def call() -> Any:
            if self._client < 0:
                raise RobotError(f"the simulated world is closed: {function.__name__}")
            try:
                return ready()
            except pybullet.error as error:
                raise RobotError(f"PyBullet refused: {function.__name__}: {error}") from error

        return call
