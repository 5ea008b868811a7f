"""The outline of the P3-DX on the floor, against walls and people's legs. Metres and radians."""

from math import cos, hypot, inf, sin
from typing import Final, NamedTuple

import numpy as np

from sim.wall_plan import WallPlan, squared_distance
from slam.compiled import compiled_on_views
from slam.pose import FloatArray

BOXES: Final = np.array([[-0.0175, 0.2275, 0.1905], [-0.2725, 0.0275, 0.15]])
"""Body and rear bumper of p3dx.urdf: middle ahead of the axle, half the length, half the width."""
RADIUS: Final = 0.34
"""Radius of the circle around the middle of the axle that contains the outline, metres."""


class Overlap(NamedTuple):
    """Overlap of the outline and an obstacle."""

    depth: float
    """Depth, metres; if negative, an upper bound of the distance between them."""
    x: float
    """The deepest point, base frame."""
    y: float


@compiled_on_views
def deepest_overlap(
    x: float, y: float, theta: float, plan: WallPlan, cell: int, legs: FloatArray, radii: FloatArray
) -> Overlap:
    """Find the deepest overlap of the robot's outline with the walls of this cell and with legs (L, 2)."""
    c, s = cos(theta), sin(theta)
    deepest = Overlap(-inf, 0.0, 0.0)
    for at in range(plan.first[cell], plan.first[cell + 1]):
        row = plan.listed[at]
        wx, wy, ux, uy = plan.walls[row, 0] - x, plan.walls[row, 1] - y, plan.walls[row, 2], plan.walls[row, 3]
        if squared_distance(wx, wy, ux, uy) > RADIUS * RADIUS:
            continue
        for box in range(len(BOXES)):
            middle, half_x, half_y = BOXES[box]
            found = wall_overlap(
                c * wx + s * wy - middle, c * wy - s * wx, c * ux + s * uy, c * uy - s * ux, half_x, half_y
            )
            if found.depth > deepest.depth:
                deepest = Overlap(found.depth, found.x + middle, found.y)
    for leg in range(len(radii)):
        dx, dy = legs[leg, 0] - x, legs[leg, 1] - y
        if dx * dx + dy * dy > (RADIUS + radii[leg]) ** 2:
            continue
        for box in range(len(BOXES)):
            middle, half_x, half_y = BOXES[box]
            px, py = c * dx + s * dy, c * dy - s * dx
            depth = radii[leg] - _distance(px - middle, py, half_x, half_y)
            if depth > deepest.depth:
                deepest = Overlap(depth, px, py)
    return deepest


@compiled_on_views
def wall_overlap(x: float, y: float, ux: float, uy: float, half_x: float, half_y: float) -> Overlap:
    """Find the point of the wall from (x, y) to (x + ux, y + uy) that is deepest in a box around the origin.

    The depth min(half_x - |x|, half_y - |y|) is concave and piecewise linear along the wall: its maximum lies at an end
    or at a change between pieces.
    """
    found = _deeper(Overlap(-inf, 0.0, 0.0), 0.0, x, y, ux, uy, half_x, half_y)
    found = _deeper(found, 1.0, x, y, ux, uy, half_x, half_y)
    found = _deeper(found, -x / ux, x, y, ux, uy, half_x, half_y)
    found = _deeper(found, -y / uy, x, y, ux, uy, half_x, half_y)
    for sx in (-1.0, 1.0):
        for sy in (-1.0, 1.0):
            share = (half_x - half_y - sx * x + sy * y) / (sx * ux - sy * uy)
            found = _deeper(found, share, x, y, ux, uy, half_x, half_y)
    return found


@compiled_on_views
def _deeper(
    found: Overlap, share: float, x: float, y: float, ux: float, uy: float, half_x: float, half_y: float
) -> Overlap:
    """Return the point at this share of the wall, if it is on the wall and deeper than ``found``; else ``found``."""
    if not 0.0 <= share <= 1.0:
        return found
    px, py = x + share * ux, y + share * uy
    depth = min(half_x - abs(px), half_y - abs(py))
    return Overlap(depth, px, py) if depth > found.depth else found


@compiled_on_views
def _distance(x: float, y: float, half_x: float, half_y: float) -> float:
    """Return the distance of a point from a box around the origin; negative inside."""
    out_x, out_y = abs(x) - half_x, abs(y) - half_y
    if out_x <= 0.0 and out_y <= 0.0:
        return max(out_x, out_y)
    return hypot(max(out_x, 0.0), max(out_y, 0.0))
