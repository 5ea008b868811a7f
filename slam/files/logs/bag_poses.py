"""Poses in a bag: along the time of its scans, and in the tree of its frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from slam.errors import LogError
from slam.files.ros.decoder import Transform
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class PoseSeries:
    """Poses of one frame in another, in the order of their stamps."""

    stamps: FloatArray
    """Seconds, strictly increasing, shape (K,)."""
    poses: FloatArray
    """x, y, theta, metres and radians, theta without jumps, shape (K, 3)."""
    twists: FloatArray | None = None
    """Linear and angular velocity, shape (K, 2); None where all of them are zero, as where nobody measured them."""

    @classmethod
    def of_poses(cls, poses: Sequence[tuple[float, Pose2D]]) -> PoseSeries:
        """A track of poses with their stamps, at least one; the first of those with one stamp counts."""
        return cls.of_odometry([Odometry(stamp, pose) for stamp, pose in poses])

    @classmethod
    def of_odometry(cls, odometry: Sequence[Odometry]) -> PoseSeries:
        """A track with its velocities."""
        table = np.array([(o.stamp, *o.T_odom_base.as_array(), o.twist.linear, o.twist.angular) for o in odometry])
        _, first = np.unique(table[:, 0], return_index=True)
        table = table[first]
        table[:, 3] = np.unwrap(table[:, 3])
        twists = table[:, 4:] if table[:, 4:].any() else None
        return cls(table[:, 0], table[:, 1:4], twists)

    def poses_at(self, stamps: FloatArray) -> FloatArray:
        """Poses (N, 3) at these stamps, in proportion to the time between two; before the first and after the last it
        stands."""
        return _interpolated(stamps, self.stamps, self.poses)

    def twists_at(self, stamps: FloatArray) -> FloatArray | None:
        """Velocities (N, 2) at these stamps, likewise."""
        return None if self.twists is None else _interpolated(stamps, self.stamps, self.twists)

    def covers(self, stamps: FloatArray, margin: float = 0.5) -> bool:
        """True where no stamp lies farther than ``margin`` seconds outside."""
        return bool(stamps[0] >= self.stamps[0] - margin and stamps[-1] <= self.stamps[-1] + margin)


def _interpolated(at: FloatArray, stamps: FloatArray, rows: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(at, stamps, column) for column in rows.T])


class FrameTree:
    """The first transform to each frame."""

    def __init__(self, transforms: Iterable[Transform]) -> None:
        self._links: dict[str, Transform] = {}
        for transform in transforms:
            self._links.setdefault(transform.child, transform)

    def mount(self, base: str, sensor: str) -> Pose2D | None:
        """``T_base_sensor``; None where nothing joins them. LogError where the sensor does not lie level."""
        below_base = self._above(base)
        for frame, T_frame_sensor, level in self._above(sensor):
            for other, T_other_base, level_base in below_base:
                if other == frame:
                    if not (level and level_base):
                        raise LogError(f"the transforms from {base} to {sensor} tilt the lidar; need it level")
                    return T_other_base.inverse() @ T_frame_sensor
        return None

    def _above(self, frame: str) -> list[tuple[str, Pose2D, bool]]:
        """The frame and all above it, with the pose of the frame in each, and whether it lies level there."""
        pose, level, above = Pose2D(), True, [(frame, Pose2D(), True)]
        while (link := self._links.get(frame)) is not None and len(above) <= len(self._links):
            frame, pose, level = link.frame, link.pose @ pose, level and link.level
            above.append((frame, pose, level))
        return above
