"""The thread of a driver, which survives the loss of its device and bugs of the driver."""

import logging
import threading
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from slam.errors import RobotError

_LOG: Final = logging.getLogger("hopslam.device")
_FIRST_PAUSE: Final = 0.1
_LONGEST_PAUSE: Final = 2.0
"""Seconds between two attempts to reach a device again."""


class DeviceThread:
    """Calls ``serve`` again and again; when that raises, ``lose``, then ``connect`` until it succeeds.

    ``serve`` handles what arrives within a fraction of a second. RobotError means that the device is lost; any other
    exception is a bug in the driver, which is logged with its traceback and handled in the same way. Once ``leaving``
    is set, a lost device is not reported.
    """

    def __init__(
        self,
        name: str,
        serve: Callable[[], None],
        lose: Callable[[], None],
        connect: Callable[[], None],
        leaving: threading.Event,
    ) -> None:
        self._name = name
        self._leaving = leaving
        self._serve, self._lose, self._connect = serve, lose, connect
        self._closing = threading.Event()
        self.trouble: str | None = None
        """Reason why the device is not served; ``serve`` clears it once the device works again."""
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread; closing twice is allowed."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                self._serve()
            except Exception as error:  # noqa: BLE001  # a robot must not be left without its driver
                self._reconnect(self._reason(error))

    def _reconnect(self, reason: str) -> None:
        """Try again at growing intervals until the device answers or the driver is closed."""
        self.trouble = reason
        _LOG.log(logging.INFO if self._leaving.is_set() else logging.WARNING, "%s", reason)
        self._lose()
        for _ in self._attempts():
            try:
                self._connect()
            except Exception as error:  # noqa: BLE001
                self.trouble = self._reason(error)
                continue
            _LOG.warning("the %s is back", self._name)
            return

    def _attempts(self) -> Iterator[None]:
        pause = _FIRST_PAUSE
        while not self._closing.wait(pause):
            yield
            pause = min(2.0 * pause, _LONGEST_PAUSE)

    def _reason(self, error: Exception) -> str:
        if isinstance(error, RobotError):
            return str(error)
        place = traceback.extract_tb(error.__traceback__)[-1]
        fault = f"{type(error).__name__}: {error} ({Path(place.filename).name}, line {place.lineno})"
        return f"the driver of the {self._name} failed and starts again: {fault}; please report this"
