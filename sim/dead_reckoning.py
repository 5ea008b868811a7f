"""Dead reckoning of the firmware, compiled: encoder ticks, the pose from them, and both as ARCOS reports them.

It has the wheel errors of the setting ``WheelErrors``. ``base`` is a record of the type BASE, ``model``
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
    """Read the encoders, and add the motion since the last reading to ``T_odom_base``."""
    left = model.own_gain_inverse * base.left - model.cross_gain_inverse * base.right
    right = model.own_gain_inverse * base.right - model.cross_gain_inverse * base.left
    left = np.rint(left * TICKS_PER_RADIAN) + np.rint(model.encoder_noise * noise[0])
    right = np.rint(right * TICKS_PER_RADIAN) + np.rint(model.encoder_noise * noise[1])
    travel_left = _travel(left - base.ticks_left, model.left_radius, model.travel_noise, noise[2])
    travel_right = _travel(right - base.ticks_right, model.right_radius, model.travel_noise, noise[3])
    base.ticks_left, base.ticks_right = int(left), int(right)
    base.travel_left += travel_left
    base.travel_right += travel_right
    ahead, turn = (travel_left + travel_right) / 2.0, (travel_right - travel_left) / model.track  # as ``wheel_motion``
    half = turn / 2.0
    chord = ahead * (sin(half) / half if abs(half) > 1e-8 else 1.0)
    x, y, c, s = chord * cos(half), chord * sin(half), cos(base.odom_theta), sin(base.odom_theta)
    base.odom_x, base.odom_y = base.odom_x + c * x - s * y, base.odom_y + s * x + c * y
    base.odom_theta = wrapped(base.odom_theta + wrapped(turn))


@compiled_in_order
def _travel(ticks: float, radius: float, noise: float, slip: float) -> float:
    """Return the distance, metres, that a wheel of this radius rolled; the variance of its error grows with it."""
    distance = ticks * (2.0 * pi / TICKS_PER_TURN) * radius
    return distance + noise * sqrt(abs(distance)) * slip


@compiled_in_order
def reported_pose(base: Any, model: Any) -> tuple[float, float, float]:
    """Return the reported ``T_odom_base``: x, y, theta."""
    if not model.firmware_units:
        return base.odom_x, base.odom_y, base.odom_theta
    return (
        _rounded(base.odom_x, MILLIMETRE), _rounded(base.odom_y, MILLIMETRE), _rounded(base.odom_theta, ANGLE_UNIT)
    )  # fmt: skip


@compiled_in_order
def take_mean_twist(base: Any, model: Any, seconds: float) -> tuple[float, float]:
    """Return the mean v and omega since the last call, ``seconds`` ago; 0 if no time passed."""
    rate = 1.0 / seconds if seconds > 0.0 else 0.0
    left, right = base.travel_left * rate, base.travel_right * rate
    base.travel_left = base.travel_right = 0.0
    if model.firmware_units:
        left, right = _rounded(left, MILLIMETRE), _rounded(right, MILLIMETRE)
    return (left + right) / 2.0, (right - left) / model.track


@compiled_in_order
def _rounded(value: float, unit: float) -> float:
    """Round to whole units; never to -0.0."""
    return float(np.rint(value / unit) * unit + 0.0)
