"""A recorded run: scans and the wheel odometry at each of them, in SI units and radians."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.errors import ScansLost
from slam.files.logs.streamed_ranges import StreamedRanges
from slam.lidars import Lidar
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

_LOUD: Final = 0.2
_FAILED: Final = 0.5
"""Shares of lost scans above which the user is warned, and above which a command fails."""


class Loss(NamedTuple):
    """Scans of a log that could not be used."""

    lost: int
    scans: int
    """Number of all scans, including lost ones."""
    report: str

    @property
    def share(self) -> float:
        """Share of lost scans, between 0 and 1."""
        return self.lost / max(self.scans, 1)

    @property
    def warning(self) -> str | None:
        """One line for the user, if more than a fifth is lost."""
        if self.share <= _LOUD:
            return None
        return f"{self.lost} of {self.scans} scans of the log, {self.share:.0%}, could not be used"

    def require_most(self, lenient: bool, remedy: str = "accept it with --lenient") -> None:
        """Raise ScansLost if more than half is lost, unless ``lenient``."""
        if self.share > _FAILED and not lenient:
            raise ScansLost(f"{self.warning}: {self.report}; mend the log, or {remedy}")


class FanTable(NamedTuple):
    """Fans of N scans of one lidar, each array of shape (N,). Radians and seconds."""

    angles_min: FloatArray
    angle_increments: FloatArray
    beams: NDArray[np.int64]
    time_increments: FloatArray

    @property
    def note(self) -> str:
        """Remark for the report of the log."""
        return f"its lidar takes {self.beams.min()} to {self.beams.max()} beams a scan, and each scan keeps its own"

    def fan(self, index: int, lidar: Lidar) -> Lidar:
        """Return the fan of scan ``index``, with the range limits of the lidar."""
        first, step = float(self.angles_min[index]), float(self.angle_increments[index])
        return replace(lidar, angle_min=first, angle_increment=step, beams=int(self.beams[index]))


def lidar_of(fans: Sequence[Lidar], time_increments: Sequence[float]) -> tuple[Lidar, FanTable | None]:
    """Return the lidar that took scans with these fans, at least one, and the table of the fans if they vary.

    Its range limits are the widest of them. ``time_increments`` are the seconds between two beams of each scan.
    """
    most = max(fans, key=lambda fan: fan.beams)
    if all(fan == most for fan in fans):
        return most, None
    near, far = min(fan.range_min for fan in fans), max(fan.range_max for fan in fans)
    rows = [(fan.angle_min, fan.angle_increment, fan.beams) for fan in fans]
    first, step, beams = (np.array(column) for column in zip(*rows, strict=True))
    table = FanTable(first, step, beams, np.array(time_increments))
    same = (table.beams == most.beams).all() and len({row[:2] for row in rows}) == 1
    return replace(most, range_min=near, range_max=far), None if same else table


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """N scans of one lidar, in the order of their stamps; structure of arrays, read-only."""

    lidar: Lidar
    """The lidar; ``scan_time`` is the median time between two stamps, seconds; if the number of beams varies, the
    largest fan."""
    T_base_laser: Pose2D
    stamps: FloatArray
    """Seconds on the log's own clock, strictly increasing, shape (N,)."""
    ranges: FloatArray | StreamedRanges
    """Ranges, metres; +inf is no echo and nan an erroneous reading, as in REP-117; shape (N, beams). Those of a file
    are read again on request, one row at a time; those in memory are padded with nan."""
    T_odom_base: FloatArray
    """Raw wheel odometry as rows x, y, theta, relative to the first scan; metres and radians, shape (N, 3)."""
    time_increment: float
    """Seconds between two beams, 0 if unknown."""
    skipped: Mapping[str, int]
    """Number of unusable lines, by their fault."""
    ignored: Mapping[str, int]
    """Number of messages of other types, by their names."""
    report: str
    """Summary of what was read and skipped, for display."""
    has_odometry: bool = True
    """False if the motion was not measured; ``T_odom_base`` is then constant."""
    twists: FloatArray | None = None
    """Linear and angular velocity that the base measured while the beams were taken, m/s and rad/s, shape (N, 2)."""
    start: Pose2D = field(default_factory=Pose2D)
    """``T_map_base`` at the first scan, if the log has a map."""
    T_map_base: FloatArray | None = None
    """True poses as rows x, y, theta, if the log has them; shape (N, 3)."""
    fans: FanTable | None = None
    """The fan of each scan, if they vary."""
    lost: int = 0
    """Number of scans that could not be used."""

    def __post_init__(self) -> None:
        for array in (self.stamps, self.ranges, self.T_odom_base, self.twists, self.T_map_base, *(self.fans or ())):
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    def __len__(self) -> int:
        """Number of scans."""
        return len(self.stamps)

    @property
    def loss(self) -> Loss:
        """Scans that could not be used."""
        return Loss(self.lost, self.lost + len(self), self.report)

    def scan(self, index: int) -> LaserScan:
        """Return scan ``index``, counted from 0."""
        fan, between = self.lidar, self.time_increment
        if self.fans is not None:
            fan, between = self.fans.fan(index, fan), float(self.fans.time_increments[index])
        return LaserScan(
            stamp=float(self.stamps[index]),
            angle_min=fan.angle_min,
            angle_increment=fan.angle_increment,
            range_min=fan.range_min,
            range_max=fan.range_max,
            ranges=self.ranges[index][: fan.beams],
            time_increment=between,
            scan_time=fan.scan_time,
        )

    def odometry(self, index: int) -> Odometry:
        """Return dead reckoning at scan ``index``.

        Without a measured twist, the twist is that of the motion to this scan.
        """
        twist = self.twist(index - 1) if self.twists is None else Twist2D(*self.twists[index].tolist())
        return Odometry(float(self.stamps[index]), self.pose(index), twist)

    def truth(self, index: int) -> Pose2D | None:
        """Return ``T_map_base`` at scan ``index``, if the log has it."""
        return None if self.T_map_base is None else Pose2D.from_array(self.T_map_base[index])

    def pose(self, index: int) -> Pose2D:
        """Return ``T_odom_base`` at scan ``index``."""
        return Pose2D.from_array(self.T_odom_base[index])

    def twist(self, index: int) -> Twist2D:
        """Return the mean velocity from scan ``index`` to the next one; zero outside of the log."""
        if not 0 <= index < len(self) - 1:
            return Twist2D()
        motion = self.pose(index).between(self.pose(index + 1))
        seconds = float(self.stamps[index + 1] - self.stamps[index])
        return Twist2D.from_motion(motion, seconds)


class BagTopics(NamedTuple):
    """Topics of a bag to read; None means the only one of its type."""

    scan: str | None = None
    odometry: str | None = None


def scan_time(stamps: FloatArray) -> float:
    """Median time between two stamps, seconds, in whole nanoseconds; 0.1 for a single one."""
    return round(float(np.median(np.diff(stamps))), 9) if len(stamps) > 1 else 0.1
