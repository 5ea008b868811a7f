"""The odometry of a robot, interpolated at the time of a scan."""

import threading
import time
from collections import deque
from typing import Final

import numpy as np

from slam.files.logs.bag_poses import PoseSeries
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D

_KEPT: Final = 256
"""Number of messages that are kept: five seconds at 50 Hz."""
_RESTART: Final = 1.0
"""Step back in time, seconds, that shows that the clock was set back."""
_FARTHEST: Final = 0.25
"""Seconds after the last message for which its speed still predicts the pose."""


class HeardOdometry:
    """Messages of odometry, oldest first; threads of a bus add to it, and the program reads it."""

    def __init__(self) -> None:
        self._news = threading.Condition()
        self._heard: deque[Odometry] = deque(maxlen=_KEPT)

    @property
    def last(self) -> Odometry | None:
        """Newest message; None before the first."""
        return self._heard[-1] if self._heard else None

    def add(self, odometry: Odometry) -> None:
        """Append a message that is later than all before it; after a long step back in time, start again."""
        with self._news:
            if self._heard and self._heard[-1].stamp - odometry.stamp > _RESTART:
                self._heard.clear()
            if not self._heard or odometry.stamp > self._heard[-1].stamp:
                self._heard.append(odometry)
                self._news.notify_all()

    def at(self, stamp: float, until: float) -> Odometry | None:
        """Return pose and speed at this time, interpolated between two messages.

        Waits for a later message until the monotonic time ``until``; then the pose is predicted from the last one for
        up to a quarter of a second. None if both fail.
        """
        with self._news:
            self._news.wait_for(lambda: self._reaches(stamp), max(0.0, until - time.monotonic()))
            heard = list(self._heard)
        if not heard or not heard[0].stamp <= stamp <= heard[-1].stamp + _FARTHEST:
            return None
        last = heard[-1]
        if stamp >= last.stamp:
            return Odometry(stamp, last.T_odom_base @ last.twist.motion(stamp - last.stamp), last.twist)
        return _between(heard, stamp)

    def _reaches(self, stamp: float) -> bool:
        return bool(self._heard) and self._heard[-1].stamp >= stamp


def _between(heard: list[Odometry], stamp: float) -> Odometry:
    after = next(index for index, odometry in enumerate(heard) if odometry.stamp > stamp)
    series, at = PoseSeries.of_odometry(heard[after - 1 : after + 1]), np.array([stamp])
    twists = series.twists_at(at)
    twist = Twist2D() if twists is None else Twist2D(*twists[0].tolist())
    return Odometry(stamp, Pose2D.from_array(series.poses_at(at)[0]), twist)
