"""What an agent commands: two numbers, in SI units."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box

from slam.errors import InputError
from slam.odometry import Twist2D
from slam.pose import FloatArray


def action_space() -> Box:
    """Both numbers within -1 and 1: m/s and rad/s, or m/s at the rims of the wheels. No scale is hidden in it."""
    return Box(-1.0, 1.0, (2,), np.float32)


def twist_action(action: Any) -> Twist2D:
    """Forward and turning velocity, (v, omega), as a command."""
    linear, angular = _two_numbers(action, "(v, omega)")
    return Twist2D(float(linear), float(angular))


def wheels_action(action: Any, track: float) -> Twist2D:
    """Speeds of the left and the right wheel at their rims, m/s, as a command; they are ``track`` metres apart."""
    left, right = _two_numbers(action, "(left, right)")
    return Twist2D(float(left + right) / 2.0, float(right - left) / track)


def _two_numbers(action: Any, meaning: str) -> FloatArray:
    try:
        numbers = np.asarray(action, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"an action is {meaning}, two numbers; {action!r} is not") from error
    if numbers.shape != (2,):
        raise InputError(f"an action is {meaning}, of shape (2,); this one has shape {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise InputError(f"an action is {meaning}, finite numbers; this is {numbers.tolist()}: did learning diverge?")
    return numbers
