"""The seam between the emulated devices and the world that they stand in."""

from __future__ import annotations

from typing import Protocol

from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D


class Plant(Protocol):
    """A base with two wheels and a lidar, somewhere. Its time passes in ``advance`` only."""

    @property
    def T_map_base(self) -> Pose2D:
        """Where the base really is."""
        ...

    @property
    def elapsed(self) -> float:
        """Seconds that have passed in ``advance``."""
        ...

    @property
    def odometry(self) -> Pose2D:
        """Where the wheels say that the base is, in the frame where it was put down."""
        ...

    @property
    def travel(self) -> tuple[float, float]:
        """Metres that the left and the right wheel have rolled, as the encoders say."""
        ...

    @property
    def stalled(self) -> bool:
        """Whether the wheels cannot turn as they should."""
        ...

    def advance(self, seconds: float, setpoint: Twist2D) -> None:
        """Let time pass with the motors at this speed, which the firmware ramps."""
        ...

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        """What the lidar would measure in these directions of its own frame, metres, inf without an echo: the first
        beam fires ``ahead`` seconds from now, the others ``increment`` seconds after one another, all at the speed of
        now."""
        ...

    def bumpers(self) -> tuple[bool, ...]:
        """Which segments were pressed since the last call: front, then rear, each from left to right; () for none."""
        ...

    def sonar(self) -> tuple[float, ...]:
        """The front ring, metres from left to right, inf without an echo; () without a ring."""
        ...
