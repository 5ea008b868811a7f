"""The Robot protocol, used by the method, the learning environment, the runner and the viewer."""

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
    """One scan, the odometry and, if the back end knows it, the true pose, all at ``scan.stamp``.

    The twist of the odometry is used to deskew the scan: it is the mean from the first beam to the last, or from the
    last scan to this one if all beams are taken at once.
    """

    scan: LaserScan
    odometry: Odometry
    T_map_base: Pose2D | None = None
    collided: bool = False
    """True if the robot touched anything but the floor since the last observation; a simulated one does not count
    furniture that it can push, a real one cannot distinguish it."""
    stalled: bool = False
    """True if the base reports that a wheel cannot turn as it should."""
    bumpers: tuple[bool, ...] = ()
    """True for each pressed bumper segment, the front ones from left to right, then the rear ones; () without
    bumpers."""
    sonar: tuple[float, ...] = ()
    """Ranges of the sonar transducers in the order of ``slam.sonar_ring``, the front ring from left to right and then
    the rear one, metres, inf without an echo; () without a ring."""
    people: tuple[tuple[float, float], ...] = ()
    """Positions of people after the last beam, x and y in the map frame, metres; () for none, or if unknown."""
    battery: Battery | None = None
    """State of the battery; None if unknown."""
    fault_flags: int = 0
    """Faults that the base reports, one bit each, as its maker defines them; 0 for none."""


class Robot(Protocol):
    """A differential-drive base that carries a planar lidar: simulated, real, or recorded.

    Use it as a context manager; the end of the block stops the robot and frees its devices. ``T_base_laser`` is the
    pose of the lidar on the base.
    """

    T_base_laser: Pose2D

    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Wait for the next scan; None if there are no more.

        Raises RobotTimeout if nothing arrives within ``timeout`` seconds, RobotError if it is closed or broken.
        """
        ...

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return the one that is applied: clipped, or the recorded one in a replay."""
        ...


@runtime_checkable
class Restartable(Protocol):
    """A robot that can be reset to its start without a new object, which no real robot can."""

    def restart(self, seed: int) -> None:
        """Return to the start of the scenario, at rest, at time 0, with the noise of another seed."""
        ...
