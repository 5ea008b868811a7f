"""The Robot protocol: a robot as the method, the learning environment, the runner and the viewer know it."""

from dataclasses import dataclass
from typing import Literal, Protocol, Self, runtime_checkable

from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Battery:
    """The battery of the base."""

    volts: float
    level: Literal["good", "low", "empty"] = "good"
    """``low``: it is time to drive home. ``empty``: the robot stops."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One scan, the odometry and, where the back end knows it, the truth, all at ``scan.stamp``.

    The twist of the odometry is the mean over the time that the beams took, or since the last scan where they are taken
    at once: with it, the skew of a scan can be undone.
    """

    scan: LaserScan
    odometry: Odometry
    T_map_base: Pose2D | None = None
    collided: bool = False
    """True where the robot touched anything but the floor since the last observation; a simulated one does not count
    furniture that it can push, a real one cannot tell."""
    stalled: bool = False
    """True where the base says that a wheel cannot turn as it should."""
    bumpers: tuple[bool, ...] = ()
    """True for each bumper segment that is pressed, the front ones from left to right, then the rear
    ones; () without bumpers."""
    sonar: tuple[float, ...] = ()
    """Ranges of the sonar transducers in the order of ``slam.sonar_ring``, the front ring from left to right and then
    the rear one, metres, inf without an echo; () without a ring."""
    people: tuple[tuple[float, float], ...] = ()
    """Positions of people after the last beam, x and y in the map frame, metres; () for none, or where nobody knows."""
    battery: Battery | None = None
    """None where nobody knows."""
    fault_flags: int = 0
    """Faults that the base reports, a bit each, of its maker's meaning; 0 for none."""


class Robot(Protocol):
    """A differential-drive base that carries a planar lidar: simulated, real, or recorded.

    Use it as a context manager; leaving the block stops the robot and frees its devices. ``T_base_laser`` is where the
    lidar sits on the base.
    """

    T_base_laser: Pose2D

    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Wait for the next scan; None when there will be no more.

        Raises RobotTimeout when nothing comes within ``timeout`` seconds, RobotError when it is closed or broken.
        """
        ...

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return the one really applied: clipped, or the recorded one in a replay."""
        ...


@runtime_checkable
class Restartable(Protocol):
    """A robot that can be set back to its start without being made anew, which no real robot can."""

    def restart(self, seed: int) -> None:
        """Stand at the start of the scenario again, at rest, at time 0, with the noise of another seed."""
        ...
