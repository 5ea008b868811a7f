"""Poses in a bag: interpolated at the times of scans, and in the tree of frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import atan2
from typing import Final, NamedTuple

import numpy as np

from slam.errors import LogError
from slam.files.logs.odometry_resets import Joined, join_resets
from slam.files.ros.decoder import Transform
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D

BASES: Final = ("base_link", "base_footprint")
"""Usual names of the base frame in ROS."""
_LEVEL: Final = 0.98
"""Cosine of the tilt up to which a frame counts as level."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseSeries:
    """Poses of one frame in another, in the order of their stamps."""

    stamps: FloatArray
    """Seconds, strictly increasing, shape (K,)."""
    poses: FloatArray
    """x, y, theta, metres and radians, theta without jumps, shape (K, 3)."""
    twists: FloatArray | None = None
    """Linear and angular velocity, shape (K, 2); None if all of them are zero, that is, not measured."""

    @classmethod
    def of_poses(cls, poses: Sequence[tuple[float, Pose2D]]) -> PoseSeries:
        """Make a track of poses with their stamps, at least one; of equal stamps the first counts."""
        return cls.of_odometry([Odometry(stamp, pose) for stamp, pose in poses])

    @classmethod
    def of_odometry(cls, odometry: Sequence[Odometry]) -> PoseSeries:
        """Return the track with its velocities."""
        table = np.array([(o.stamp, *o.T_odom_base.as_array(), o.twist.linear, o.twist.angular) for o in odometry])
        _, first = np.unique(table[:, 0], return_index=True)
        table = table[first]
        table[:, 3] = np.unwrap(table[:, 3])
        twists = table[:, 4:] if table[:, 4:].any() else None
        return cls(table[:, 0], table[:, 1:4], twists)

    def joined(self) -> tuple[PoseSeries, Joined]:
        """Return the track with its resets joined, and the resets."""
        joined = join_resets(self.stamps, self.poses)
        return replace(self, poses=joined.poses), joined

    def poses_at(self, stamps: FloatArray) -> FloatArray:
        """Return poses (N, 3) at these stamps, linearly interpolated.

        Before the first and after the last pose they are constant.
        """
        return _interpolated(stamps, self.stamps, self.poses)

    def twists_at(self, stamps: FloatArray) -> FloatArray | None:
        """Return velocities (N, 2) at these stamps, interpolated in the same way."""
        return None if self.twists is None else _interpolated(stamps, self.stamps, self.twists)

    def holes(self, stamps: FloatArray, longest: float = 1.0) -> list[tuple[float, float]]:
        """Return begin and end of the times without a pose, if they are longer than ``longest`` seconds and than usual.

        Only times between the first and the last of these stamps count.
        """
        inside = self.stamps[(self.stamps > stamps[0]) & (self.stamps < stamps[-1])]
        ends = np.array([stamps[0], *inside, stamps[-1]])
        usual = float(np.median(np.diff(self.stamps))) if len(self.stamps) > 1 else 0.0
        late = np.flatnonzero(np.diff(ends) > max(longest, 3.0 * usual))
        return [(float(ends[index]), float(ends[index + 1])) for index in late]

    def covers(self, stamps: FloatArray, margin: float = 0.5) -> bool:
        """Return True if no stamp lies more than ``margin`` seconds outside."""
        return bool(stamps[0] >= self.stamps[0] - margin and stamps[-1] <= self.stamps[-1] + margin)


def _interpolated(at: FloatArray, stamps: FloatArray, rows: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(at, stamps, column) for column in rows.T])


def is_odometry(link: Transform) -> bool:
    """Return True for a transform from a frame of odometry to a base."""
    return "odom" in link.frame.rpartition("/")[2] and link.child.rpartition("/")[2] in BASES


class Mount(NamedTuple):
    """Place of a lidar on its robot, seen from above."""

    T_base_laser: Pose2D
    inverted: bool = False
    """True if the lidar hangs upside down, so that its bearings increase clockwise."""


class FrameTree:
    """The tree of frames: the first transform to each."""

    def __init__(self, transforms: Iterable[Transform]) -> None:
        self._links: dict[str, Transform] = {}
        for transform in transforms:
            self._links.setdefault(transform.child, transform)

    def mount(self, base: str, sensor: str) -> Mount | None:
        """Return the mount of the sensor on this base, or else on one with a usual name; None if nothing connects them.

        LogError if the sensor is tilted.
        """
        mounts = (self._mount(known, sensor) for known in (base, *BASES))
        return next((mount for mount in mounts if mount is not None), None)

    def _mount(self, base: str, sensor: str) -> Mount | None:
        below_base = self._above(base)
        for frame, sensor_links in self._above(sensor):
            for other, base_links in below_base:
                if other == frame:
                    if all(link.T_frame_child is None for link in (*base_links, *sensor_links)):
                        return Mount(_pose(base_links).inverse() @ _pose(sensor_links))
                    return _seen_from_above(_in_space(base_links), _in_space(sensor_links), f"{base} to {sensor}")
        return None

    def _above(self, frame: str) -> list[tuple[str, list[Transform]]]:
        """Return the frame and its parents, with the transforms to them, the lowest first."""
        links: list[Transform] = []
        above = [(frame, list(links))]
        while (link := self._links.get(frame)) is not None and len(above) <= len(self._links):
            links.append(link)
            frame = link.frame
            above.append((frame, list(links)))
        return above


def _pose(links: Sequence[Transform]) -> Pose2D:
    """Return the pose of the lowest frame in the highest."""
    return reduce(lambda pose, link: link.pose @ pose, links, Pose2D())


def _in_space(links: Sequence[Transform]) -> FloatArray:
    """Return the same pose in space, (4, 4)."""
    return reduce(lambda T, link: _matrix(link) @ T, links, np.eye(4))


def _matrix(link: Transform) -> FloatArray:
    if link.T_frame_child is not None:
        return link.T_frame_child
    c, s, pose = np.cos(link.pose.theta), np.sin(link.pose.theta), link.pose
    return np.array([[c, -s, 0.0, pose.x], [s, c, 0.0, pose.y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _seen_from_above(T_top_base: FloatArray, T_top_sensor: FloatArray, names: str) -> Mount:
    """Return the mount between two frames in space; LogError if their z axes are not parallel."""
    T = np.linalg.solve(T_top_base, T_top_sensor)
    if not abs(T[2, 2]) > _LEVEL:
        tilt = np.degrees(np.arccos(np.clip(T[2, 2], -1.0, 1.0)))
        raise LogError(
            f"the transforms from {names} tilt the lidar by {tilt:.0f} degrees; need it level or upside down"
        )
    return Mount(Pose2D(float(T[0, 3]), float(T[1, 3]), atan2(T[1, 0], T[0, 0])), bool(T[2, 2] < 0.0))
