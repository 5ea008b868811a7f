"""Planar lidars: their beams and range limits; the known models, with their makers' error bounds."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Final, Literal

import numpy as np

from slam.pose import FloatArray

_SEVEN_DIGITS: Final = 1.5e-7
"""Relative error of a number with seven digits, and of single precision."""
_MIN_STEP: Final = 1e-6
"""Largest deviation of a first bearing from a whole number of half steps, radians."""


@dataclass(frozen=True, slots=True)
class Lidar:
    """A planar lidar, described by its beams and its range limits. Radians, metres, seconds."""

    angle_min: float
    angle_increment: float
    beams: int
    range_min: float
    range_max: float
    scan_time: float

    @property
    def angle_max(self) -> float:
        """Bearing of the last beam."""
        return self.angle_min + (self.beams - 1) * self.angle_increment

    @property
    def whole_turn(self) -> bool:
        """True if the first beam follows the last one, within a step and a half."""
        return self.beams * self.angle_increment > 2.0 * pi - 0.5 * self.angle_increment

    @property
    def angles(self) -> FloatArray:
        """Bearings of all beams in the sensor frame, shape (beams,), from ahead.

        They are theta_k(j) of eq. (1) less 90 degrees, as the paper has its y axis ahead (Fig. 2).
        """
        return self.angle_min + self.angle_increment * np.arange(self.beams, dtype=np.float64)


def whole_steps(angle_min: float, angle_increment: float) -> tuple[float, float] | None:
    """Return first bearing and step, given to seven digits or more, as the exact values that they stand for.

    A lidar divides the turn into a whole number of steps, and begins at a whole number of half steps. None if that does
    not fit.
    """
    if not angle_increment > _MIN_STEP:
        return None
    step = 2.0 * pi / max(round(2.0 * pi / angle_increment), 1)
    first = round(2.0 * angle_min / step) * step / 2.0
    fits = abs(step - angle_increment) <= _SEVEN_DIGITS * step and abs(first - angle_min) <= _SEVEN_DIGITS * abs(
        angle_min
    )
    return (first, step) if fits else None


def ordered_bearings(
    angle_min: float, angle_increment: float, beams: int, exact: Callable[[float, float], tuple[float, float]]
) -> tuple[float, float, bool]:
    """Return first bearing and step of these beams in counter-clockwise order, and True if the order was reversed.

    ``exact`` converts a first bearing and a positive step, as read, to exact values; for a clockwise fan, it gets the
    mirror image.
    """
    if angle_increment < 0.0:
        last, step = exact(-angle_min, -angle_increment)
        return -(last + (beams - 1) * step), step, True
    return *exact(angle_min, angle_increment), False


@dataclass(frozen=True, slots=True)
class LidarModel:
    """A lidar and its accuracy.

    The accuracy is plus or minus ``near_accuracy`` metres up to ``near_range``, and ``far_accuracy`` times the range
    beyond. ``resolution`` is the step of the range, metres.
    """

    lidar: Lidar
    resolution: float
    near_accuracy: float
    near_range: float
    far_accuracy: float
    noise: tuple[float, float, float] | None = None
    """The maker's bound of the noise without constant errors, three standard deviations: near accuracy, near range and
    far accuracy as above; None if the maker gives only the accuracy."""
    beams_vary: int = 0
    """Number of beams by which a turn may differ from the description."""

    @property
    def time_increment(self) -> float:
        """Seconds between two beams: the mirror turns once in ``scan_time``."""
        return self.lidar.scan_time * self.lidar.angle_increment / (2.0 * pi)

    def accuracy(self, ranges: FloatArray) -> FloatArray:
        """Return the maker's bound of the error at each of these ranges, metres."""
        return np.where(ranges <= self.near_range, self.near_accuracy, self.far_accuracy * ranges)


_EIGHT_STEPS: Final = 2.0 * pi / 192
"""Step of the paper's lidar: 240 degrees by 128 beams."""
TABLE1: Final = LidarModel(
    lidar=Lidar(
        angle_min=-63.5 * _EIGHT_STEPS,
        angle_increment=_EIGHT_STEPS,
        beams=128,
        range_min=0.06,
        range_max=4.0,
        scan_time=0.1,
    ),
    resolution=(4.0 - 0.06) / 1024,  # 3.85 mm, printed as 3.84
    near_accuracy=0.025,
    near_range=1.0,
    far_accuracy=0.025,
    noise=(0.010, 1.0, 0.01),
)
"""The simulated URG-04LX of the paper's Table 1: it has 128 beams, and the real one 682."""

URG04LX: Final = LidarModel(
    lidar=Lidar(
        angle_min=(44 - 384) * 2.0 * pi / 1024,
        angle_increment=2.0 * pi / 1024,
        beams=725 - 44 + 1,
        range_min=0.06,
        range_max=4.095,
        scan_time=0.1,
    ),
    resolution=0.001,
    near_accuracy=0.025,
    near_range=1.0,
    far_accuracy=0.025,
    noise=(0.010, 1.0, 0.01),
)
"""Hokuyo URG-04LX: steps 44 to 725 of 1024 per turn, front at step 384, so the fan is not symmetric; 600 rpm. Its
accuracy is that of the paper's Table 1, which defines noise levels; its noise is what Hokuyo states."""

LD19: Final = LidarModel(
    lidar=Lidar(
        angle_min=-pi,
        angle_increment=2.0 * pi / 450,
        beams=450,
        range_min=0.02,
        range_max=12.0,
        scan_time=0.1,
    ),
    resolution=0.001,
    near_accuracy=0.045,
    near_range=12.0,
    far_accuracy=0.045 / 12.0,
    noise=(0.030, 12.0, 0.030 / 12.0),
    beams_vary=5,
)
"""LDROBOT LD19: a whole turn at 10 Hz, 4500 ranges per second at any speed, +-45 mm, standard deviation 10 mm (data
sheet, 70 % reflectivity). The real one turns clockwise."""

LidarName = Literal["table1", "urg04lx", "ld19"]
LIDARS: Final[dict[LidarName, LidarModel]] = {"table1": TABLE1, "urg04lx": URG04LX, "ld19": LD19}
