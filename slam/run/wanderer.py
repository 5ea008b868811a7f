"""Driving about without knowing where one is: on the scans alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.pilot import Pilot
from slam.scan import LaserScan

SPEED: Final = 0.5
"""m/s, at most ..."""
TURN_SPEED: Final = 0.8
"""... and rad/s."""
HALF_WIDTH: Final = 0.35
"""Metres to each side of the middle that must be free ahead."""
STOP: Final = 0.5
"""The robot turns on the spot when something is nearer ahead than this, metres ..."""
GO: Final = 0.9
"""... and until nothing is nearer than this."""


class Wanderer:
    """Goes where there is room, turns where there is none, and is never done; the pose is not asked for."""

    progress = 0.0

    def __init__(self) -> None:
        self._turning = 0.0  # rad/s, while it turns on the spot

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D:
        """What to drive from what is seen."""
        ahead, side = _room(scan)
        if ahead < (GO if self._turning else STOP):
            self._turning = self._turning or float(np.copysign(TURN_SPEED, side))
            return Twist2D(0.0, self._turning)
        self._turning = 0.0
        return Twist2D(min(SPEED, ahead - 0.4 * STOP), float(np.clip(side, -TURN_SPEED, TURN_SPEED)))


def _room(scan: LaserScan) -> tuple[float, float]:
    """Metres that are free ahead, and to which side there is more room: positive to the left, near 1 at most."""
    ranges = np.where(scan.echoes, scan.ranges, np.where(np.isposinf(scan.ranges), scan.range_max, np.inf))
    known, angles = np.isfinite(ranges), scan.bearings
    x, y = ranges[known] * np.cos(angles[known]), ranges[known] * np.sin(angles[known])
    ahead = x[(np.abs(y) < HALF_WIDTH) & (x > 0.0)]
    front = np.abs(angles[known]) < 0.5 * np.pi
    side = float(y[front].sum() / max(np.abs(y[front]).sum(), 1e-9)) if front.any() else 0.0
    return float(ahead.min()) if len(ahead) else 0.0, side


class FindThenDrive:
    """Wanders while the place is not known, and drives as another pilot says while it is."""

    def __init__(self, known: Callable[[], bool], then: Pilot) -> None:
        self._known, self._then, self._wanderer = known, then, Wanderer()

    @property
    def progress(self) -> float:
        """Of the other pilot."""
        return self._then.progress

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """What to drive from this estimated pose, if it is known, or from what is seen."""
        return (self._then if self._known() else self._wanderer).command(T_map_base, scan)
