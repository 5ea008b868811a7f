"""A recorded run: scans and the wheel odometry at each of them, in SI units and radians."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from slam.lidars import Lidar
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """N scans of one lidar, in the order of their stamps; structure of arrays, read-only."""

    lidar: Lidar
    """``scan_time`` is the median time between two stamps, seconds."""
    T_base_laser: Pose2D
    stamps: FloatArray
    """Seconds on the log's own clock, strictly increasing, shape (N,)."""
    ranges: FloatArray
    """Metres; +inf is no echo and nan an erroneous reading, as REP-117 has it; shape (N, beams)."""
    T_odom_base: FloatArray
    """Raw wheel odometry as rows x, y, theta, relative to the first scan; metres and radians, shape (N, 3)."""
    time_increment: float
    """Seconds between two beams, 0 where it is not known."""
    skipped: Mapping[str, int]
    """Number of unusable lines, by what was wrong with them."""
    ignored: Mapping[str, int]
    """Number of messages of other types, by their names."""
    report: str
    """Summary of what was read and what was not, one line to show."""
    has_odometry: bool = True
    """False: nobody measured the motion, and ``T_odom_base`` stands still."""
    twists: FloatArray | None = None
    """Linear and angular velocity that the base measured while the beams were taken, m/s and rad/s, shape (N, 2)."""
    start: Pose2D = field(default_factory=Pose2D)
    """``T_map_base`` at the first scan, where the log knows a map."""
    T_map_base: FloatArray | None = None
    """The truth as rows x, y, theta, where the log knows it; shape (N, 3)."""

    def __post_init__(self) -> None:
        for array in (self.stamps, self.ranges, self.T_odom_base, self.twists, self.T_map_base):
            if array is not None:
                array.flags.writeable = False

    def __len__(self) -> int:
        """Number of scans."""
        return len(self.stamps)

    def scan(self, index: int) -> LaserScan:
        """The scan of that number, from 0."""
        fan = self.lidar
        return LaserScan(
            stamp=float(self.stamps[index]),
            angle_min=fan.angle_min,
            angle_increment=fan.angle_increment,
            range_min=fan.range_min,
            range_max=fan.range_max,
            ranges=self.ranges[index],
            time_increment=self.time_increment,
            scan_time=fan.scan_time,
        )

    def odometry(self, index: int) -> Odometry:
        """Dead reckoning at that scan; where no twist was measured, it is that of the motion which led there."""
        twist = self.twist(index - 1) if self.twists is None else Twist2D(*self.twists[index].tolist())
        return Odometry(float(self.stamps[index]), self.pose(index), twist)

    def truth(self, index: int) -> Pose2D | None:
        """``T_map_base`` at that scan, where the log knows it."""
        return None if self.T_map_base is None else Pose2D.from_array(self.T_map_base[index])

    def pose(self, index: int) -> Pose2D:
        """``T_odom_base`` at that scan."""
        return Pose2D.from_array(self.T_odom_base[index])

    def twist(self, index: int) -> Twist2D:
        """Mean velocity from that scan to the next one; zero outside of the log."""
        if not 0 <= index < len(self) - 1:
            return Twist2D()
        motion = self.pose(index).between(self.pose(index + 1))
        seconds = float(self.stamps[index + 1] - self.stamps[index])
        return Twist2D.from_motion(motion, seconds)


class BagTopics(NamedTuple):
    """Topics of a bag to read; None: the only one of its type."""

    scan: str | None = None
    odometry: str | None = None


def scan_time(stamps: FloatArray) -> float:
    """Median time between two stamps, seconds; 0.1 for a single one."""
    return float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.1
