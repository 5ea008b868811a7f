"""The Mapper protocol: a matcher with its map, as LineSlam uses it."""

from typing import Protocol

from slam.lines.segments import Segments
from slam.matching.match import Match
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan


class Points(Protocol):
    """A part of the map that can be shown as points."""

    @property
    def points(self) -> FloatArray:
        """Shape (N, 2), metres, map frame."""
        ...

    def __len__(self) -> int: ...


class Lines(Protocol):
    """A part of the map that can be shown as lines."""

    @property
    def ends(self) -> FloatArray:
        """Shape (M, 2, 2): [line, start or end, x or y]; metres, map frame; the lidar was to the left of the line."""
        ...


class Mapper(Protocol):
    """A matcher and the map that it matches to."""

    @property
    def points(self) -> Points: ...
    @property
    def lines(self) -> Lines: ...

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """Match a scan, with the prior pose ``prior`` of the base, map frame."""
        ...

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """Add the last located scan to the map."""
        ...
