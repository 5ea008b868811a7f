"""The Pioneer P3-DX of a scenario: its start, the errors of its wheels, the floor, its limits."""

from math import pi
from typing import Annotated

from pydantic import Field

from slam.config import Section
from slam.scenario.values import NotNegative, Place, Positive, SmallLength, Speed, TurnSpeed, Within

Acceleration = Annotated[Positive, Within(0.0, 50.0, "m/s^2", "mm/s^2", 1e-3)]


class WheelErrors(Section):
    """Wheel sizes that the firmware assumes when it controls the wheels and computes the odometry.

    The robot itself has wheels of 0.0975 m radius, 0.330 m apart; if the assumptions differ, its path differs from the
    odometry.
    """

    left_radius: SmallLength = 0.0975
    """Radius that the firmware assumes for the left wheel, metres."""
    right_radius: SmallLength = 0.0975
    """Radius that the firmware assumes for the right wheel, metres."""
    track: SmallLength = 0.330
    """Wheel track that the firmware assumes, metres. The vendor's parameters give 0.357, which is correct on a floor
    with ``traction.effective_track = 0.357``."""
    travel_noise: Annotated[NotNegative, Within(0.0, 1.0, "m", "mm", 1e-3)] = 0.0
    """Random slip: standard deviation of each wheel's reported distance after one metre, metres. It grows with the
    square root of the distance."""
    encoder_noise: NotNegative = 0.0
    """Standard deviation of each reading of an encoder, ticks (76,600 per turn); it does not accumulate."""
    firmware_units: bool = True
    """True: odometry is rounded as in ARCOS: whole millimetres, 4096ths of a turn, whole mm/s of each wheel."""


class Traction(Section):
    """Slip and scrub between wheels and floor, which the encoders do not measure."""

    slip: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """Share of each wheel's distance that is lost, at any speed."""
    effective_track: SmallLength = 0.330
    """Effective wheel track, metres: with scrubbing tyres the robot turns as if its wheels were this far apart (a real
    P3-DX: 0.357)."""
    friction: Annotated[float, Field(ge=0, le=2)] = 1.0
    """Friction coefficient between tyre and floor: about 1 on a dry floor, 0.2 on a wet one. Above 0.5, a blocked robot
    stalls; below 0.35, its wheels spin."""


class Limits(Section):
    """Limits of the base; by default its accelerations are those of an ARCOS robot."""

    linear: Speed = 1.2
    """Speed, m/s."""
    angular: TurnSpeed = 5.236
    """Turning speed, rad/s."""
    acceleration: Acceleration = 0.3
    """Acceleration, m/s^2."""
    deceleration: Acceleration = 0.6
    """Deceleration, m/s^2."""
    angular_acceleration: Annotated[Positive, Within(0.0, 50.0, "rad/s^2", "deg/s^2", pi / 180.0)] = 1.74
    """Acceleration and deceleration of turning, rad/s^2."""


class RobotConfig(Section):
    """The Pioneer P3-DX."""

    start: Place = Place()
    """Start pose of the base, map frame."""
    odometry: WheelErrors = WheelErrors()
    traction: Traction = Traction()
    limits: Limits = Limits()
    control_rate: Annotated[int, Field(ge=10, le=1000)] = 60
    """Frequency, Hz, at which the base reads its encoders and sets its motors; people move at this rate too."""
    sonar: bool = False
    """True: the front sonar ring is on."""
