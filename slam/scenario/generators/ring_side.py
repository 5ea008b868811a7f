"""A side of a ring of corridors: a passage, a wider wing, and a passage again."""

from typing import NamedTuple

import numpy as np

from slam.pose import Pose2D, unit_vectors
from slam.scenario.values import Point, readable_point
from slam.scenario.wall import Wall


class RingSide(NamedTuple):
    """A side of the ring. ``T_map_side``: x along its centre line from its first corner, y to the inside."""

    T_map_side: Pose2D
    length: float
    begin: float
    """x at which the wing begins, metres."""
    end: float
    """x at which the wing ends, metres."""
    front: float
    """Distance from the middle of the wing's corridor to the middle of its walls, metres."""

    def point(self, x: float, y: float) -> Point:
        """Transform a point of the side's frame to the map."""
        place = self.T_map_side @ Pose2D(x, y)
        return readable_point(place.x, place.y)


def walls_around_corner(before: RingSide, after: RingSide, half: float) -> list[Wall]:
    """Make the outer and the inner wall from one wing to the next, ``half`` metres beside the middle of the passage.

    At both ends, where the corridor becomes wider, they include the wall across that joins them to the wing's walls.
    """
    walls = []
    for hand in (-1.0, 1.0):
        y = hand * half
        end = before.point(before.end, hand * before.front), before.point(before.end, y)
        begin = after.point(after.begin, y), after.point(after.begin, hand * after.front)
        walls.append(Wall(points=(*end, _mitre(before, after, y), *begin)))
    return walls


def _mitre(before: RingSide, after: RingSide, y: float) -> Point:
    """Return the intersection of the lines ``y`` metres beside two sides, at their common corner."""
    left, also_left = unit_vectors(np.array([before.T_map_side.theta, after.T_map_side.theta]) + np.pi / 2.0)
    return readable_point(*(after.T_map_side.translation + y * (left + also_left) / (1.0 + left @ also_left)))
