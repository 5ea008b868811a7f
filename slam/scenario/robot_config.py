"""The Pioneer P3-DX of a scenario: its start, the errors of its wheels, the floor, its limits."""

from math import pi
from typing import Annotated

from pydantic import Field

from slam.config import Section
from slam.scenario.values import NotNegative, Place, Positive, SmallLength, Speed, TurnSpeed, Within

Acceleration = Annotated[Positive, Within(0.0, 50.0, "m/s^2", "mm/s^2", 1e-3)]


class WheelErrors(Section):
    """Wheels as the firmware assumes them to be, by which it steers the robot and makes its odometry.

    The robot itself has wheels of 0.0975 m radius, 0.330 m apart; where the assumptions differ, it does not go where
    the odometry says.
    """

    left_radius: SmallLength = 0.0975
    """Radius that the firmware assumes of the left wheel, metres."""
    right_radius: SmallLength = 0.0975
    """Radius that the firmware assumes of the right wheel, metres."""
    track: SmallLength = 0.330
    """Distance between the wheels that the firmware assumes, metres; 0.357 is what the vendor's factors say, and right
    where ``traction.effective_track`` is the same."""
    travel_noise: Annotated[NotNegative, Within(0.0, 1.0, "m", "mm", 1e-3)] = 0.0
    """Random slip: standard deviation of each wheel's reported travel after one metre, metres (grows with the root)."""
    encoder_noise: NotNegative = 0.0
    """Standard deviation of each reading of an encoder, ticks (76,600 a turn); it does not add up."""
    firmware_units: bool = True
    """Rounded as ARCOS reports: whole millimetres, 4096ths of a turn, whole mm/s of each wheel; false: not rounded."""


class Traction(Section):
    """Slip and scrub between wheels and floor, which the wheels and their encoders do not notice."""

    slip: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """Share of each wheel's travel that is lost, at any speed."""
    effective_track: SmallLength = 0.330
    """The tyres scrub when the robot turns: it turns as if its wheels were this far apart, metres (a real P3-DX:
    0.357)."""
    friction: Annotated[float, Field(ge=0, le=2)] = 1.0
    """Coefficient between tyre and floor: rubber has about 1 on a dry floor, 0.2 on a wet one. From 0.5 on, a blocked
    robot stalls; below 0.35, its wheels spin."""


class Limits(Section):
    """Limits that the base keeps to, as an ARCOS robot does."""

    linear: Speed = 1.2
    """Speed, m/s."""
    angular: TurnSpeed = 5.236
    """Turning speed, rad/s."""
    acceleration: Acceleration = 0.3
    """m/s^2."""
    deceleration: Acceleration = 0.6
    """m/s^2."""
    angular_acceleration: Annotated[Positive, Within(0.0, 50.0, "rad/s^2", "deg/s^2", pi / 180.0)] = 1.74
    """rad/s^2."""


class RobotConfig(Section):
    """The Pioneer P3-DX."""

    start: Place = Place()
    """Pose of the base when the run begins, map frame."""
    odometry: WheelErrors = WheelErrors()
    traction: Traction = Traction()
    limits: Limits = Limits()
    control_rate: Annotated[int, Field(ge=10, le=1000)] = 60
    """Times a second that the base reads its encoders and sets its motors; people walk at this rate too."""
    sonar: bool = False
    """The front sonar ring is on."""
