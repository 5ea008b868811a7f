"""The sensor's time stamps: milliseconds in 24 bits on the wire, seconds here, and their times on the host's clock."""

from typing import Final

import numpy as np

from hardware import DecodeError
from hardware.scip.encoding import decode_values, encode_values

_COUNT: Final = 2**24
TIME_WRAP: Final = _COUNT / 1000.0
"""Seconds after which the sensor's clock begins anew: 4.66 h."""
_FASTEST_DRIFT: Final = 500e-6
"""Seconds a second: more than a crystal or a resonator of such a device drifts."""


def encode_time(seconds: float) -> bytes:
    """Return the four characters that stamp a scan, and answer TM1."""
    return encode_values(np.array([_milliseconds(seconds)]), 4)


def decode_time(text: bytes) -> float:
    """Return seconds; DecodeError unless there are four characters."""
    if len(text) != 4:
        raise DecodeError(f"a time of {len(text)} characters")
    return int(decode_values(text, 4)[0]) / 1000.0


def encode_hex_time(seconds: float) -> str:
    """Return the six hexadecimal digits in the answer to II."""
    return f"{_milliseconds(seconds):06X}"


def decode_hex_time(text: str) -> float:
    """Return seconds; DecodeError for no number."""
    try:
        return int(text, 16) / 1000.0
    except ValueError:
        raise DecodeError("no number TIME") from None


def _milliseconds(seconds: float) -> int:
    return round(seconds * 1000.0) % _COUNT


class SensorClock:
    """Maps the sensor's time stamps to the host's clock: unwraps them, and follows offset and drift.

    An event reaches the host some time after it happened: at least ``least_delay`` seconds, which are known, and a
    varying time more. The smallest difference of the two clocks seen is the true one, and the estimate follows it down
    at once; upwards it creeps as fast as the drift may be, so that it keeps to the least delays of the recent past.
    """

    def __init__(self, least_delay: float = 0.0, wrap: float = TIME_WRAP) -> None:
        self._wrap = wrap
        self._least_delay = least_delay
        self._sensor: float | None = None
        self._offset = 0.0

    @property
    def running(self) -> bool:
        """True once it has seen an arrival."""
        return self._sensor is not None

    def host_time(self, sensor_time: float, arrival: float) -> float:
        """Return the host's time of the event stamped ``sensor_time``, word of which came at ``arrival``; seconds.

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
