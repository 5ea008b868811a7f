"""Times of a sensor's own clock, mapped to the host's."""

from math import inf
from typing import Final

_FASTEST_DRIFT: Final = 500e-6
"""Seconds a second: more than a crystal or a resonator of such a device drifts."""
_LEAST_STEP: Final = 1e-3
"""Seconds between two times at least."""
_JITTER: Final = 0.02
"""Seconds by which an ordinary arrival may be earlier than all before it, and the times still be trusted."""


class SensorClock:
    """Maps the sensor's time stamps to the host's clock: unwraps them, and follows offset and drift.

    Stamps begin anew after ``wrap`` seconds. An event reaches the host some time after it happened: at least
    ``least_delay`` seconds, which are known, and a varying time more. The smallest difference of the two clocks seen is
    the true one, and the estimate follows it down at once; upwards it creeps as fast as the drift may be, so that it
    keeps to the least delays of the recent past. Times rise strictly, from ``after`` on: while arrivals that the link
    had held back move the estimate down, they rise by the least step, and the clock is not ``settled``.
    """

    def __init__(self, wrap: float, least_delay: float = 0.0, after: float = -inf) -> None:
        self._wrap = wrap
        self._least_delay = least_delay
        self._sensor: float | None = None
        self._offset = 0.0
        self._latest = after
        self.settled = False
        """True where the last arrival was about as early as those before it, so that the times are right."""

    @property
    def running(self) -> bool:
        """True once it has seen an arrival."""
        return self._sensor is not None

    @property
    def latest(self) -> float:
        """Newest time that it has returned."""
        return self._latest

    def host_time(self, sensor_time: float, arrival: float) -> float:
        """Return the host's time of the event stamped ``sensor_time`` that was heard of at ``arrival``, seconds.

        The sensor's times of successive calls increase by less than ``wrap``. An ``arrival`` may be later than the real
        one, but for the first.
        """
        passed = 0.0 if self._sensor is None else (sensor_time - self._sensor) % self._wrap
        expected = inf if self._sensor is None else self._offset + _FASTEST_DRIFT * passed
        self._sensor = sensor_time if self._sensor is None else self._sensor + passed
        self._offset = min(expected, arrival - self._least_delay - self._sensor)
        estimate, earliest = self._sensor + self._offset, self._latest + _LEAST_STEP
        self.settled = expected - self._offset <= _JITTER and estimate >= earliest
        self._latest = max(estimate, earliest)
        return self._latest
