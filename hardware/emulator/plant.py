"""The plant, in the sense of control engineering: the robot's body and world, which the emulated devices control."""

from typing import Protocol

from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D


class Plant(Protocol):
    """A base with two wheels and a lidar in a world. Its time passes in ``advance`` only."""

    @property
    def T_map_base(self) -> Pose2D:
        """True pose of the base."""
        ...

    @property
    def elapsed(self) -> float:
        """Seconds that have passed in ``advance``."""
        ...

    @property
    def odometry(self) -> Pose2D:
        """Pose of the base by its wheels, in the frame of its start."""
        ...

    @property
    def travel(self) -> tuple[float, float]:
        """Metres that the left and the right wheel have rolled, by the encoders."""
        ...

    @property
    def stalled(self) -> bool:
        """True while the wheels cannot turn as they should."""
        ...

    def advance(self, seconds: float, setpoint: Twist2D) -> None:
        """Let time pass with the motors at this speed, which the firmware has ramped."""
        ...

    def ranges(self, bearings: FloatArray, ahead: float = 0.0, increment: float = 0.0) -> FloatArray:
        """Return the ranges that the lidar measures in these directions of its own frame, metres, inf without an echo.

        The first beam fires ``ahead`` seconds from now, the others ``increment`` seconds apart, while the base keeps
        its present speed.
        """
        ...

    def bumpers(self) -> tuple[bool, ...]:
        """Return True for each segment pressed since the last call.

        Front segments come first, then rear ones, each from left to right; () if the robot has no bumpers.
        """
        ...

    def sonar(self) -> tuple[float, ...]:
        """Return the ranges of the front ring, metres from left to right, inf without an echo; () without a ring."""
        ...
