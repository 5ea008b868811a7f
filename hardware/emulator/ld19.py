"""The emulated LD19: it turns and sends all the time, twelve points per packet, and takes no commands."""

from math import pi, sin
from typing import Final

import numpy as np

from hardware.emulator.plant import Plant
from hardware.ldrobot import BAUD, POINTS, LdPacket
from slam.pose import FloatArray

_POINT_TIME: Final = 1.0 / 4500.0
"""Seconds from point to point, whatever the speed (data sheet: ranging frequency)."""
_TOGETHER: Final = 4
"""Packets that arrive together, as from a USB adapter."""
_PERIOD: Final = _TOGETHER * POINTS * _POINT_TIME
_START: Final = 0.7
"""Seconds from power-up to the first packet (LD19 Development Manual); the emulator starts after that."""
_SPEED_ERROR: Final = 0.01
"""Relative amplitude of the motor speed's swing, which varies the number of points per turn."""
_SWING: Final = 2.0 * pi / 3.0
"""Angular frequency of that swing, rad/s."""
_SHOWN: Final = 450
_INTENSITY: Final = 200


class EmulatedLd19:
    """Measures all the time.

    ``drift`` is the relative error of its clock against the plant's (positive: fast), ``rate`` the turns per second;
    ``paced`` has no effect.
    """

    def __init__(
        self, plant: Plant, now: float = 0.0, drift: float = 0.0, paced: bool = True, rate: float = 10.0
    ) -> None:
        self._plant = plant
        self._plant_began = now - plant.elapsed
        self._powered_at = now - _START
        self._drift = drift
        self.rate = rate
        """Turns per second."""
        self._angle = 0.0
        self.due = now + _PERIOD
        self.baud = BAUD
        self.laser = True
        self.dead = False
        self._bearings = -2.0 * pi * np.arange(_SHOWN) / _SHOWN
        self._ranges = np.full(_SHOWN, np.nan)

    @property
    def wake(self) -> float:
        """Time of the next packets."""
        return self.due

    @property
    def sweep(self) -> tuple[FloatArray, FloatArray]:
        """Bearings in the sensor's frame, and the last range measured at each, nan before the first; (N,) each."""
        return self._bearings, self._ranges

    def set_dead(self, dead: bool) -> None:
        """Fall silent, or come back to life."""
        self.dead = dead

    def reboot(self, now: float) -> None:
        """Simulate a power failure: the clock begins at 0, and the sensor is silent for a while."""
        self._powered_at = now

    def receive(self, data: bytes, now: float) -> bytes:
        """Ignore the data: this sensor only sends."""
        return b""

    def step(self) -> bytes:
        """Measure the points of the packets that are due, and send them."""
        began, self.due = self.due - _PERIOD, self.due + _PERIOD
        turned = (1.0 + _SPEED_ERROR * sin(_SWING * (began - self._powered_at))) * 2.0 * pi * self.rate
        angles: FloatArray = self._angle + turned * _POINT_TIME * np.arange(_TOGETHER * POINTS, dtype=np.float64)
        self._angle = (self._angle + turned * _PERIOD) % (2.0 * pi)
        if self.dead or began - self._powered_at < _START:
            return b""
        ahead = began - self._plant_began - self._plant.elapsed
        ranges = self._plant.ranges(-angles, ahead, _POINT_TIME)
        self._ranges[np.round(angles / (2.0 * pi) * _SHOWN).astype(int) % _SHOWN] = ranges
        return b"".join(
            self._packet(angles[k : k + POINTS], ranges[k : k + POINTS], turned, began + (k + POINTS - 1) * _POINT_TIME)
            for k in range(0, len(angles), POINTS)
        )

    def _packet(self, angles: FloatArray, ranges: FloatArray, speed: float, time: float) -> bytes:
        intensities = tuple(_INTENSITY if metres < np.inf else 0 for metres in ranges.tolist())
        clock = (time - self._powered_at) * (1.0 + self._drift)
        return LdPacket(speed, float(angles[0]), float(angles[-1]), ranges, intensities, clock).encode()
