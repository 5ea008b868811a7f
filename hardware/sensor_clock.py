"""The clock of a sensor as read on the host's: offset, drift, and the delays of the line."""

from __future__ import annotations

from typing import Final

_FASTEST_DRIFT: Final = 500e-6
"""Seconds a second: more than a crystal or a resonator of such a device drifts."""


class SensorClock:
    """Maps the times of a sensor to the host's.

    An event reaches the host some time after it happened: at least ``least_delay`` seconds, which are known, and a
    varying time more. The smallest difference of the two clocks seen is the true one, and the estimate follows it down
    at once; upwards it creeps as fast as the drift may be, so that it keeps to the least delays of the recent past.
    """

    def __init__(self, wrap: float, least_delay: float = 0.0) -> None:
        self._wrap = wrap
        self._least_delay = least_delay
        self._sensor: float | None = None
        self._offset = 0.0

    @property
    def running(self) -> bool:
        """Whether it has seen an arrival."""
        return self._sensor is not None

    def host_time(self, sensor_time: float, arrival: float) -> float:
        """When it was ``sensor_time`` (seconds modulo ``wrap``), of which word came at ``arrival`` on the host's clock.

        The times of successive calls increase by less than ``wrap``. After the first one ``arrival`` may be
        inf: unknown.
        """
        if self._sensor is None:
            self._sensor = sensor_time
            self._offset = arrival - self._least_delay - sensor_time
            return arrival - self._least_delay
        passed = (sensor_time - self._sensor) % self._wrap
        self._sensor += passed
        seen = arrival - self._least_delay - self._sensor
        self._offset = min(seen, self._offset + _FASTEST_DRIFT * passed)
        return self._sensor + self._offset
