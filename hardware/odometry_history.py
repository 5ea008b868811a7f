"""The base's pose at any time of the last seconds, from reports at 10 Hz."""

from bisect import bisect_right
from collections import deque
from typing import Final

import numpy as np

from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D

_KEPT: Final = 64
"""Reports that are kept: those of six seconds."""
_FARTHEST: Final = 0.25
"""Seconds after the last report for which its speed still predicts the pose."""
_GAP: Final = 0.5
"""Seconds between two reports beyond which the path from one to the other is unknown."""


class OdometryHistory:
    """Poses ``T_odom_base`` and speeds by time, seconds; between two of them the base moves along an arc."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque(maxlen=_KEPT)
        self._poses: deque[Pose2D] = deque(maxlen=_KEPT)
        self._twists: deque[Twist2D] = deque(maxlen=_KEPT)

    @property
    def last(self) -> tuple[float, Pose2D] | None:
        """Stamp and pose of the newest report."""
        return (self._stamps[-1], self._poses[-1]) if self._stamps else None

    def add(self, stamp: float, pose: Pose2D, twist: Twist2D) -> None:
        """Append a report, later than all before it, and the speed at that time."""
        if self._stamps and stamp - self._stamps[-1] > _GAP:
            for kept in (self._stamps, self._poses, self._twists):
                kept.clear()
        self._stamps.append(stamp)
        self._poses.append(pose)
        self._twists.append(twist)

    def covers(self, stamp: float) -> bool:
        """Return True if the pose at this time is known."""
        return bool(self._stamps) and self._stamps[0] <= stamp <= self._stamps[-1] + _FARTHEST

    def pose_at(self, stamp: float) -> Pose2D:
        """Return the pose at a time that the history covers: between two reports, or predicted from the last one."""
        after = bisect_right(self._stamps, stamp)
        if after == len(self._stamps):
            return self._poses[-1] @ self._twists[-1].motion(stamp - self._stamps[-1])
        if after == 0:
            return self._poses[0]
        begin, end = self._stamps[after - 1], self._stamps[after]
        step = self._poses[after - 1].between(self._poses[after])
        return self._poses[after - 1] @ Twist2D.from_motion(step, end - begin).motion(stamp - begin)

    def between(self, first: float, last: float) -> Odometry:
        """Return the odometry at the time ``first``, with the mean speed between there and ``last``."""
        return Odometry(first, self.pose_at(first), self._mean_speed(first, last))

    def _mean_speed(self, first: float, last: float) -> Twist2D:
        """Average the reported speeds, assuming a linear change between reports.

        Speeds in whole mm/s are more exact than differences of poses in whole mm, and show the ramps.
        """
        begin, end = sorted((first, last))
        times = [begin, *(stamp for stamp in self._stamps if begin < stamp < end), end]
        known = np.array([(twist.linear, twist.angular) for twist in self._twists])
        means = (np.trapezoid(np.interp(times, self._stamps, speed), times) / (end - begin) for speed in known.T)
        return Twist2D(*map(float, means))
