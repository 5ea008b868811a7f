"""Where the base was at any time of the last seconds, from reports that come ten times a second."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from math import cos, sin
from typing import Final

from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D

_KEPT: Final = 64
"""Reports: six seconds."""
_FARTHEST: Final = 0.25
"""Seconds beyond the last report for which its speed still says where the base is."""


class OdometryTrack:
    """Poses ``T_odom_base`` by time, seconds; between two of them the base goes along an arc."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque(maxlen=_KEPT)
        self._poses: deque[Pose2D] = deque(maxlen=_KEPT)
        self._twist = Twist2D()

    @property
    def last(self) -> tuple[float, Pose2D] | None:
        """The newest report."""
        return (self._stamps[-1], self._poses[-1]) if self._stamps else None

    def add(self, stamp: float, pose: Pose2D, twist: Twist2D) -> None:
        """A report, later than all before it, and the speed at that time."""
        self._stamps.append(stamp)
        self._poses.append(pose)
        self._twist = twist

    def covers(self, stamp: float) -> bool:
        """Whether the base's place at this time is known."""
        return bool(self._stamps) and self._stamps[0] <= stamp <= self._stamps[-1] + _FARTHEST

    def pose_at(self, stamp: float) -> Pose2D:
        """The place at a time that the track covers: between two reports, or carried on at the last speed."""
        after = bisect_right(self._stamps, stamp)
        if after == len(self._stamps):
            return self._poses[-1] @ self._twist.motion(stamp - self._stamps[-1])
        if after == 0:
            return self._poses[0]
        begin, end = self._stamps[after - 1], self._stamps[after]
        step = self._poses[after - 1].between(self._poses[after])
        return self._poses[after - 1] @ mean_twist(step, end - begin).motion(stamp - begin)

    def between(self, first: float, last: float) -> Odometry:
        """Odometry at the time ``first``, with the mean speed from there to ``last``."""
        start = self.pose_at(first)
        return Odometry(first, start, mean_twist(start.between(self.pose_at(last)), last - first))


def mean_twist(motion: Pose2D, seconds: float) -> Twist2D:
    """The constant speed that makes this motion: the inverse of ``Twist2D.motion``, but for what slips sideways."""
    half = motion.theta / 2.0
    chord = motion.x * cos(half) + motion.y * sin(half)
    stretch = half / sin(half) if abs(half) > 1e-8 else 1.0
    return Twist2D(chord * stretch / seconds, motion.theta / seconds) if seconds > 0.0 else Twist2D()
