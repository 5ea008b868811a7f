"""Dead reckoning of the firmware, compiled: the encoders' ticks, their sum as a pose, and both as ARCOS reports them.

It has the wrong beliefs and the errors on purpose of ``WheelErrors``. ``base`` is a record of the type BASE, ``model``
one of the type MODEL: sim/records.py.
"""

from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np

from sim.wheels import ANGLE_UNIT, MILLIMETRE, TICKS_PER_RADIAN, TICKS_PER_TURN
from slam.compiled import compiled_in_order, wrapped

Noise = tuple[float, float, float, float]
"""Standard normal numbers for ``encoder_noise`` of the left and the right wheel, then for their ``travel_noise``."""


@compiled_in_order
def reckon(base: Any, model: Any, noise: Noise) -> None:
    """Read the encoders, and add the way since the last reading to ``T_odom_base``."""
    left = model.same_back * base.left - model.other_back * base.right
    right = model.same_back * base.right - model.other_back * base.left
    left = np.rint(left * TICKS_PER_RADIAN) + np.rint(model.encoder_noise * noise[0])
    right = np.rint(right * TICKS_PER_RADIAN) + np.rint(model.encoder_noise * noise[1])
    way_left = _travel(left - base.ticks_left, model.left_radius, model.travel_noise, noise[2])
    way_right = _travel(right - base.ticks_right, model.right_radius, model.travel_noise, noise[3])
    base.ticks_left, base.ticks_right = int(left), int(right)
    base.way_left += way_left
    base.way_right += way_right
    ahead, turn = (way_left + way_right) / 2.0, (way_right - way_left) / model.track  # as ``wheel_motion``
    half = turn / 2.0
    chord = ahead * (sin(half) / half if abs(half) > 1e-8 else 1.0)
    x, y, c, s = chord * cos(half), chord * sin(half), cos(base.odom_theta), sin(base.odom_theta)
    base.odom_x, base.odom_y = base.odom_x + c * x - s * y, base.odom_y + s * x + c * y
    base.odom_theta = wrapped(base.odom_theta + wrapped(turn))


@compiled_in_order
def _travel(ticks: float, radius: float, noise: float, slip: float) -> float:
    """Metres that a wheel believed of this radius rolled; the variance of the error grows with the way."""
    way = ticks * (2.0 * pi / TICKS_PER_TURN) * radius
    return way + noise * sqrt(abs(way)) * slip


@compiled_in_order
def reported_pose(base: Any, model: Any) -> tuple[float, float, float]:
    """``T_odom_base``: x, y, theta."""
    if not model.firmware_units:
        return base.odom_x, base.odom_y, base.odom_theta
    return (
        _rounded(base.odom_x, MILLIMETRE), _rounded(base.odom_y, MILLIMETRE), _rounded(base.odom_theta, ANGLE_UNIT)
    )  # fmt: skip


@compiled_in_order
def take_mean_twist(base: Any, model: Any, seconds: float) -> tuple[float, float]:
    """Mean v and omega since the last call, ``seconds`` ago; 0 where no time passed."""
    rate = 1.0 / seconds if seconds > 0.0 else 0.0
    left, right = base.way_left * rate, base.way_right * rate
    base.way_left = base.way_right = 0.0
    if model.firmware_units:
        left, right = _rounded(left, MILLIMETRE), _rounded(right, MILLIMETRE)
    return (left + right) / 2.0, (right - left) / model.track


@compiled_in_order
def _rounded(value: float, unit: float) -> float:
    """Round to whole units; never to -0.0."""
    return float(np.rint(value / unit) * unit + 0.0)
