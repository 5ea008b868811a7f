"""Stops the robot when commands, scans or odometry are stale."""

import logging
import threading
from collections.abc import Callable
from typing import Final

_LOG: Final = logging.getLogger("hopslam.guard")
_PERIOD: Final = 0.04
"""Seconds between two checks."""
_AGAIN: Final = 0.2
"""Seconds to the next check after a stop, which is repeated in case it was lost."""


class StalenessGuard:
    """Checks the age of all inputs on its own thread, and calls ``halt`` repeatedly while one is stale.

    ``ages`` returns, for each input's name, the age of its newest value and the largest age allowed, seconds. Nothing
    is checked while the robot is not meant to move.
    """

    def __init__(self, ages: Callable[[], dict[str, tuple[float, float]]], halt: Callable[[], None]) -> None:
        self._ages = ages
        self._halt = halt
        self._closing = threading.Event()
        self.moving = False
        self.reason: str | None = None
        self._thread = threading.Thread(target=self._watch, name="guard", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the checks; closing twice is allowed."""
        self._closing.set()
        self._thread.join()

    def stale_input(self) -> str | None:
        """Return the name of an input that is too old, with its age; None if all are fresh."""
        for name, (age, limit) in self._ages().items():
            if age > limit:
                return f"no {name} for {age:.1f} s"
        return None

    def stop(self, reason: str) -> None:
        """Stop the robot, and log the reason once."""
        self._halt()
        if self.reason is None:
            _LOG.warning("the robot is stopped: %s", reason)
        self.reason = reason

    def _watch(self) -> None:
        while not self._closing.wait(_PERIOD):
            reason = self.stale_input() if self.moving else None
            if reason is not None:
                self.stop(reason)
                self._closing.wait(_AGAIN)
