"""An interval z-buffer: each wall and leg is intersected only with the rays of a fan that can hit it.

It is exact for any rays, and fastest for a fan: rays from one place, evenly spaced.
"""

from math import asin, ceil, hypot
from typing import Final, NamedTuple

import numpy as np

from sim.wall_plan import WallPlan, cell_near, squared_distance
from slam.compiled import compiled_on_views
from slam.pose import FloatArray


class Fan(NamedTuple):
    """Bounds of rays whose bearings are about evenly spaced; uneven ones are slower."""

    x: float
    """Middle of the rays' origins."""
    y: float
    spread: float
    """Upper bound of the distance from the middle to an origin."""
    bearing: float
    """Bearing of the first ray."""
    step: float
    """Angle from ray to ray, radians; 0 if the rays are not a fan."""
    bend: float
    """Largest distance of a bearing from even spacing, radians."""


ROUGH: Final = 1.5e-5
"""Largest error of a rough bearing, radians."""


@compiled_on_views
def fan_of(rays: FloatArray) -> Fan:
    """Find the bounds of rays (5, N), as in ``sim/rays.py``."""
    bearings = rays[4]
    low_x, high_x = _span(rays[0])
    low_y, high_y = _span(rays[1])
    step = (bearings[-1] - bearings[0]) / max(len(bearings) - 1, 1)
    bend = 0.0
    for j in range(len(bearings)):
        bend = max(bend, abs(bearings[j] - bearings[0] - j * step))
    spread = 0.5 * hypot(high_x - low_x, high_y - low_y)
    return Fan(0.5 * (low_x + high_x), 0.5 * (low_y + high_y), spread, bearings[0], step if step > 1e-9 else 0.0, bend)


@compiled_on_views
def _span(numbers: FloatArray) -> tuple[float, float]:
    """Return the least and the largest number."""
    low = high = numbers[0]
    for k in range(len(numbers)):
        low, high = min(low, numbers[k]), max(high, numbers[k])
    return low, high


@compiled_on_views
def fan_interval(fan: Fan, begin: float, width: float, turn: int, rays: int) -> tuple[int, int]:
    """Return the first ray of an interval of bearings, and the one after its last.

    The bearings are ``begin`` to ``begin + width``, plus ``turn`` full turns, -1 to 1. A few more rays may be included.
    """
    if fan.step == 0.0 or width + 2.0 * fan.bend >= 2.0 * np.pi:
        return 0, rays if turn == 0 else 0
    begin -= fan.bearing + fan.bend + 1e-9
    begin += 2.0 * np.pi * (turn - np.floor(begin / (2.0 * np.pi)))
    first = max(ceil(begin / fan.step), 0)
    stop = int(np.floor((begin + width + 2.0 * fan.bend + 2e-9) / fan.step)) + 1
    return first, max(min(stop, rays), first)


@compiled_on_views
def stop_at_walls(rays: FloatArray, ranges: FloatArray, plan: WallPlan, world: int) -> None:
    """Shorten ``ranges`` (N,), at most the plan's range limit, where a wall of this world is nearer along a ray.

    The rays of a turning lidar begin at different places, at most ``spread`` from their middle. Seen from there, the
    bearing of a wall's end at distance d differs by at most asin(spread / d) from that seen from the middle.
    """
    fan = fan_of(rays)
    far = (plan.reach + fan.spread) ** 2
    n = cell_near(plan, world, fan.x, fan.y, fan.spread)
    for at in range(plan.first[n], plan.first[n + 1]):
        row = plan.listed[at]
        x, y, ux, uy = plan.walls[row, 0], plan.walls[row, 1], plan.walls[row, 2], plan.walls[row, 3]
        squared = squared_distance(x - fan.x, y - fan.y, ux, uy)
        if squared > far:
            continue
        begin, width = _bearings_of(x - fan.x, y - fan.y, ux, uy, squared, fan.spread)
        for turn in range(-1, 2):
            first, stop = fan_interval(fan, begin, width, turn, len(ranges))
            _stop_at_wall(rays, ranges, first, stop, x, y, ux, uy)


@compiled_on_views
def _bearings_of(x: float, y: float, ux: float, uy: float, squared: float, spread: float) -> tuple[float, float]:
    """Return the first bearing, and the width, of a wall seen from anywhere within ``spread`` of the origin.

    ``squared`` is the square of its distance from the origin.
    """
    if squared <= 1.001 * spread * spread + 1e-12:
        return 0.0, 2.0 * np.pi
    if x * uy - y * ux < 0.0:  # the ends in counter-clockwise order
        x, y, ux, uy = x + ux, y + uy, -ux, -uy
    begin = rough_bearing(x, y)
    width = rough_bearing(x + ux, y + uy) - begin
    width += 2.0 * np.pi * (width < -2.0 * ROUGH)
    margin, end_margin = _parallax(spread, x, y) + ROUGH, _parallax(spread, x + ux, y + uy) + ROUGH
    first = min(-margin, width - end_margin)  # another ray's origin may see the ends in the opposite order
    return begin + first, max(margin, width + end_margin) - first


@compiled_on_views
def _parallax(spread: float, x: float, y: float) -> float:
    """Return an upper bound of asin(spread / distance)."""
    ratio = spread / np.sqrt(x * x + y * y)
    return float(ratio * (1.0 + 0.5708 * ratio * ratio))


@compiled_on_views
def rough_bearing(x: float, y: float) -> float:
    """Return the bearing of a point, within ROUGH: Abramowitz and Stegun, 4.4.49."""
    flat = abs(y) <= abs(x)
    z = y / x if flat else x / y
    w = z * z
    angle = z * (0.999866 + w * (-0.3302995 + w * (0.180141 + w * (-0.085133 + w * 0.0208351))))
    if flat:
        return angle if x > 0.0 else angle + float(np.copysign(np.pi, y))
    return float(np.copysign(np.pi / 2.0, y) - angle)


@compiled_on_views
def _stop_at_wall(
    rays: FloatArray, ranges: FloatArray, first: int, stop: int, wx: float, wy: float, ux: float, uy: float
) -> None:
    """Intersect the rays from ``first`` to ``stop`` with one wall.

    The wall is extended by 1e-12 at both ends, so that no ray passes where two walls meet.
    """
    ox, oy, dx, dy = rays[0, first:stop], rays[1, first:stop], rays[2, first:stop], rays[3, first:stop]
    nearest = ranges[first:stop]
    for j in range(len(nearest)):
        x, y = wx - ox[j], wy - oy[j]
        inverse = 1.0 / (dx[j] * uy - dy[j] * ux)
        along, share = (x * uy - y * ux) * inverse, (x * dy[j] - y * dx[j]) * inverse
        met = (along >= 0.0) & (along < nearest[j]) & (share >= -1e-12) & (share <= 1.0 + 1e-12)
        nearest[j] = along if met else nearest[j]


@compiled_on_views
def stop_at_legs(rays: FloatArray, ranges: FloatArray, legs: FloatArray, radii: FloatArray, steps: float) -> None:
    """Shorten ``ranges`` (N,) where a leg, a circle of ``radii`` (L,), is nearer at the time of the ray.

    ``legs`` (C, L, 2) are the positions at C times; from one ray to the next the time advances by ``steps`` rows.
    """
    fan = fan_of(rays)
    for leg in range(len(radii)):
        low_x, high_x = _span(legs[:, leg, 0])
        low_y, high_y = _span(legs[:, leg, 1])
        middle_x, middle_y = 0.5 * (low_x + high_x) - fan.x, 0.5 * (low_y + high_y) - fan.y
        near = radii[leg] + fan.spread + 0.5 * hypot(high_x - low_x, high_y - low_y)
        distance = hypot(middle_x, middle_y)
        half = asin(near / distance) + 1e-9 if near < distance else np.pi
        for turn in range(-1, 2):
            first, stop = fan_interval(fan, np.arctan2(middle_y, middle_x) - half, 2.0 * half, turn, len(ranges))
            _stop_at_leg(rays, ranges, first, stop, legs[:, leg], radii[leg], steps)


@compiled_on_views
def _stop_at_leg(
    rays: FloatArray, ranges: FloatArray, first: int, stop: int, path: FloatArray, radius: float, steps: float
) -> None:
    last = len(path) - 1
    for j in range(first, stop):
        k = min(int(j * steps), last)
        n, share = min(k + 1, last), j * steps - k
        x = path[k, 0] + share * (path[n, 0] - path[k, 0]) - rays[0, j]
        y = path[k, 1] + share * (path[n, 1] - path[k, 1]) - rays[1, j]
        along = x * rays[2, j] + y * rays[3, j]
        across = x * rays[3, j] - y * rays[2, j]
        inside = radius * radius - across * across
        if along > 0.0 and inside > 0.0:
            ranges[j] = min(ranges[j], max(along - np.sqrt(inside), 0.0))
