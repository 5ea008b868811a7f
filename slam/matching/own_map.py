"""The map of a matcher of the user's own, checked whenever it is shown."""

from __future__ import annotations

from typing import Any

from slam.own_checks import expect_array, expect_parts
from slam.pose import FloatArray


class OwnPoints:
    """The part of the map that is shown as points; InputError where it cannot be."""

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
    """The part of the map that is shown as lines; InputError where it cannot be."""

    def __init__(self, place: str, part: Any) -> None:
        expect_parts(place, part, ("ends",), "set of lines")
        self._place, self._part = place, part

    @property
    def ends(self) -> FloatArray:
        """Shape (M, 2, 2): [line, start or end, x or y]; metres, map frame."""
        return expect_array(f"{self._place}.ends", self._part.ends, (None, 2, 2))
