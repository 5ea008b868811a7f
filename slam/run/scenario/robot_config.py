"""The Pioneer P3-DX of a scenario: where it starts, what is wrong with its wheels, what it obeys."""

from __future__ import annotations

from slam.config import Section
from slam.run.scenario.values import NotNegative, Place, Positive


class WheelErrors(Section):
    """What is wrong with the wheel odometry. The robot itself has wheels of 0.0975 m radius, 0.330 m apart."""

    left_radius: Positive = 0.0975
    """Radius that the odometry believes of the left wheel, metres."""
    right_radius: Positive = 0.0975
    """The same of the right wheel, metres."""
    track: Positive = 0.330
    """Distance between the wheels that the odometry believes, metres."""
    travel_noise: NotNegative = 0.0
    """Random error of each wheel's travel: its standard deviation after one metre, metres (grows with the root)."""


class Limits(Section):
    """What the base obeys, as an ARCOS robot does."""

    linear: Positive = 1.2
    """Speed, m/s."""
    angular: Positive = 5.236
    """Turning speed, rad/s."""
    acceleration: Positive = 0.3
    """m/s^2."""
    deceleration: Positive = 0.6
    """m/s^2."""
    angular_acceleration: Positive = 1.74
    """rad/s^2."""


class RobotConfig(Section):
    """The Pioneer P3-DX."""

    start: Place = Place()
    """Where the base stands at first, map frame."""
    odometry: WheelErrors = WheelErrors()
    limits: Limits = Limits()
