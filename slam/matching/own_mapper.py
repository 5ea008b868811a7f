"""A user's own matcher with its map, both checked at every call."""

from __future__ import annotations

from typing import Any

from slam.config import OwnMethod
from slam.lines.segments import Segments
from slam.matching.match import Match
from slam.named_code import call
from slam.own_checks import expect, expect_array, expect_numbers, expect_parts
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan


class OwnMapper:
    """Calls the user's matcher, and checks its results.

    Raises a one-line InputError naming the matcher if it cannot be created, lacks a part, raises or returns no Match.
    """

    def __init__(self, config: OwnMethod, T_base_laser: Pose2D, seed: int) -> None:
        self._place = place = config.method
        self._mapper = mapper = config.call(T_base_laser, seed=seed)
        expect_parts(place, mapper, ("locate", "add", "points", "lines"), "matcher")
        _ = self.points, self.lines

    @property
    def points(self) -> OwnPoints:
        """The part of its map that can be shown as points."""
        return OwnPoints(f"{self._place}.points", self._mapper.points)

    @property
    def lines(self) -> OwnLines:
        """The part of its map that can be shown as lines."""
        return OwnLines(f"{self._place}.lines", self._mapper.lines)

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """See Mapper."""
        match: Match = self._call("locate", scan, segments, prior)
        expect(f"{self._place}.locate", match, Match)
        expect(f"{self._place}.locate: Match.T_prior_laser", match.T_prior_laser, Pose2D)
        what = f"{self._place}.locate returned a Match whose"
        expect_numbers(f"{what} T_prior_laser.", match.T_prior_laser, ("x", "y", "theta"))
        expect_numbers(f"{what} ", match, ("iterations", "points", "inliers"))
        if match.covariance is not None:
            expect_array(f"{what} covariance", match.covariance, (3, 3))
        if match.unconstrained is not None:
            expect_array(f"{what} unconstrained", match.unconstrained, (None, 3))
        return match

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """See Mapper."""
        self._call("add", scan, segments, T_map_laser)

    def _call(self, name: str, *arguments: Any) -> Any:
        return call(f"{self._place}.{name}", getattr(self._mapper, name), *arguments)


class OwnPoints:
    """The points of the user's map, for display; InputError if they are missing or their shape is wrong."""

    def __init__(self, place: str, part: Any) -> None:
        expect_parts(place, part, ("points", "__len__"), "set of points")
        self._place, self._part = place, part

    @property
    def points(self) -> FloatArray:
        """Shape (N, 2), metres, map frame."""
        return expect_array(f"{self._place}.points", self._part.points, (None, 2))

    def __len__(self) -> int:
        return len(self._part)


class OwnLines:
    """The lines of the user's map, for display; InputError if they are missing or their shape is wrong."""

    def __init__(self, place: str, part: Any) -> None:
        expect_parts(place, part, ("ends",), "set of lines")
        self._place, self._part = place, part

    @property
    def ends(self) -> FloatArray:
        """Shape (M, 2, 2): [line, start or end, x or y]; metres, map frame."""
        return expect_array(f"{self._place}.ends", self._part.ends, (None, 2, 2))
