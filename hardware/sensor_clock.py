"""Maps times of a sensor's own clock to the host's."""

from math import inf
from typing import Final

_FASTEST_DRIFT: Final = 500e-6
"""Largest relative drift: more than a crystal or a resonator of such a device has."""
_MIN_STEP: Final = 1e-3
"""Least seconds between two times."""
_JITTER: Final = 0.02
"""Seconds by which an arrival may be earlier than all before it while the times are still trusted."""


class SensorClock:
    """Maps the sensor's time stamps to the host's clock: unwraps them, and follows offset and drift.

    Stamps wrap after ``wrap`` seconds. An event reaches the host after a known delay of at least ``least_delay``
    seconds, plus a varying one. The offset of the two clocks is therefore estimated from the events with the shortest
    delays: a smaller difference is taken over at once, a larger one only as fast as the clocks can drift.

    The returned times always increase, and begin after ``after``. If the first events arrived late, their times are
    too late, and the estimate drops when an event arrives in time. Until it has caught up with the returned times,
    these increase by the least step, and ``settled`` is False.
    """

    def __init__(self, wrap: float, least_delay: float = 0.0, after: float = -inf) -> None:
        self._wrap = wrap
        self._least_delay = least_delay
        self._sensor: float | None = None
        self._offset = 0.0
        self._latest = after
        self.settled = False
        """True if the last arrival was about as early as those before it, so that the times can be trusted."""

    @property
    def running(self) -> bool:
        """True once it has seen an arrival."""
        return self._sensor is not None

    @property
    def latest(self) -> float:
        """Newest time that it has returned."""
        return self._latest

    def host_time(self, sensor_time: float, arrival: float) -> float:
        """Return the host's time of the event stamped ``sensor_time`` that arrived at ``arrival``, seconds.

        Successive events must be less than ``wrap`` apart. ``arrival`` may be later than the true time of arrival.
        """
        passed = 0.0 if self._sensor is None else (sensor_time - self._sensor) % self._wrap
        expected = inf if self._sensor is None else self._offset + _FASTEST_DRIFT * passed
        self._sensor = sensor_time if self._sensor is None else self._sensor + passed
        self._offset = min(expected, arrival - self._least_delay - self._sensor)
        estimate, earliest = self._sensor + self._offset, self._latest + _MIN_STEP
        self.settled = expected - self._offset <= _JITTER and estimate >= earliest
        self._latest = max(estimate, earliest)
        return self._latest
