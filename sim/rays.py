"""The beams of one sweep as rays in the plane, each with origin and direction. Metres, radians, map frame.

Rays are five rows, (5, N): x, y of the origin, x, y of the unit direction, and the bearing, which is not wrapped.
"""

from dataclasses import dataclass, field
from math import ceil, cos, sin

import numpy as np

from slam.compiled import compiled_on_views, wrapped
from slam.pose import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ScanMotion:
    """Motion of the base, of legs and of furniture while the beams fired; the first beam fires at row 0."""

    path: FloatArray
    """(S, 3): x, y, theta of ``T_map_base``, one row every ``step`` seconds; a single row means no motion."""
    legs: FloatArray
    """(S, L, 2): positions of people's legs at the same times."""
    step: float
    things: FloatArray = field(default_factory=lambda: np.empty((1, 0, 3)))
    """(S, M, 3): x, y, theta of the furniture that can be pushed, at the same times."""


@compiled_on_views
def fire_beams(
    path: FloatArray, step: float, mount: FloatArray, bearings: FloatArray, beams: FloatArray, time_increment: float,
    rays: FloatArray,
) -> None:  # fmt: skip
    """Write the ``rays`` (5, N) of beams that each start at the sensor's position when they fire.

    ``mount`` (2,) is the position of the sensor on the base; ``bearings`` (N,) and the unit vectors ``beams`` (2, N)
    are the directions of its beams, in the base frame. Between two rows of ``path`` the pose changes linearly.
    """
    last, j = len(path) - 1, 0
    for k in range(len(path)):
        n = min(k + 1, last)
        end = len(bearings)
        if k < last and time_increment > 0.0:
            end = min(end, ceil((k + 1) * step / time_increment))
        turn = wrapped(path[n, 2] - path[k, 2])
        _fire(path[k], path[n], turn, mount, bearings, beams, j, end, time_increment / step, float(k), rays)
        j = max(j, end)


@compiled_on_views
def _fire(
    begin: FloatArray, end: FloatArray, turn: float, mount: FloatArray, bearings: FloatArray, beams: FloatArray,
    first: int, stop: int, steps: float, row: float, rays: FloatArray,
) -> None:  # fmt: skip
    """Write the rays of the beams ``first`` to ``stop``, between two rows of the path."""
    x0, y0, theta, dx, dy = begin[0], begin[1], begin[2], end[0] - begin[0], end[1] - begin[1]
    c0, s0, mx, my = cos(theta + turn / 2.0), sin(theta + turn / 2.0), mount[0], mount[1]
    x, y, ux, uy = rays[0, first:stop], rays[1, first:stop], rays[2, first:stop], rays[3, first:stop]
    heading = rays[4, first:stop]
    bx, by, bearing = beams[0, first:stop], beams[1, first:stop], bearings[first:stop]
    begun = first * steps - row - 0.5
    for j in range(len(bearing)):  # few arrays in each loop, so that the compiler vectorises it
        c, s = small_rotation((begun + j * steps) * turn)
        x[j], y[j] = c0 * c - s0 * s, s0 * c + c0 * s  # holds cosine and sine of the heading until the end
    for j in range(len(bearing)):
        ux[j] = x[j] * bx[j] - y[j] * by[j]
    for j in range(len(bearing)):
        uy[j] = y[j] * bx[j] + x[j] * by[j]
    for j in range(len(bearing)):
        c, s, share = x[j], y[j], begun + j * steps + 0.5
        x[j], y[j] = x0 + share * dx + c * mx - s * my, y0 + share * dy + s * mx + c * my
    for j in range(len(bearing)):
        heading[j] = theta + (begun + j * steps + 0.5) * turn + bearing[j]


@compiled_on_views
def small_rotation(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle by their series: exact to 1e-15 up to half a radian, to 1e-8 up to pi / 2."""
    z = -angle * angle
    c = 1.0 + z / 2.0 * (1.0 + z / 12.0 * (1.0 + z / 30.0 * (1.0 + z / 56.0 * (1.0 + z / 90.0 * (1.0 + z / 132.0)))))
    s = angle * (
        1.0 + z / 6.0 * (1.0 + z / 20.0 * (1.0 + z / 42.0 * (1.0 + z / 72.0 * (1.0 + z / 110.0 * (1.0 + z / 156.0)))))
    )
    return c, s
