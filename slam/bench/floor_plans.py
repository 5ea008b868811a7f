"""Floor plans of four families for the line benchmark, with beam casting: corridor, clutter, office, room.

A plan is an array of walls (W, 2, 2), each [[x0, y0], [x1, y1]] in metres. The sensor stands at the origin, and two
walls that touch are never parts of one straight line.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.solids import rectangle

CLEARANCE: Final = 0.45  # metres around the sensor that are free


def corridor(random: np.random.Generator) -> FloatArray:
    """A straight corridor, longer than the sensor sees, with door recesses on both sides."""
    width = random.uniform(1.4, 2.6)
    place = Pose2D(0.0, random.uniform(-0.3, 0.3) * width)
    left, right = _recessed(random), _recessed(random)
    sides = [left + np.array([0.0, width / 2]), right * [1.0, -1.0] - np.array([0.0, width / 2])]
    return place.transform(np.concatenate(sides).reshape(-1, 2)).reshape(-1, 2, 2)


def room(random: np.random.Generator) -> FloatArray:
    """A plain room: four walls, one of them oblique in every other room, and a corner cut off in every third."""
    length, width = random.uniform(3.0, 6.5), random.uniform(3.0, 5.0)
    corners = rectangle((0.0, 0.0), length, width, 0.0)
    corners[2, 0] -= random.choice([0.0, random.uniform(0.2, 0.5)])
    if random.random() < 1 / 3:
        cut = random.uniform(0.4, 0.9)
        corners = np.concatenate([[corners[0] + [cut, 0.0]], corners[1:], [corners[0] + [0.0, cut]]])
    return _outline(corners + random.uniform(-0.25, 0.25, 2) * [length, width])


def clutter(random: np.random.Generator) -> FloatArray:
    """A room with boxes at all angles and thin square posts."""
    boxes = [_box(random, (0.2, 0.9), (0.2, 0.9), random.uniform(0, np.pi)) for _ in range(random.integers(4, 9))]
    posts = [_box(random, (0.04, 0.12), (0.04, 0.12), random.uniform(0, np.pi)) for _ in range(random.integers(3, 7))]
    return np.concatenate([room(random), *boxes, *posts])


def office(random: np.random.Generator) -> FloatArray:
    """A room with desks, cupboards and thin partitions, nearly square to its walls."""
    desks = [_box(random, (0.9, 1.7), (0.5, 0.8), _nearly_square(random)) for _ in range(random.integers(1, 4))]
    cupboards = [_box(random, (0.4, 0.9), (0.3, 0.5), _nearly_square(random)) for _ in range(random.integers(1, 4))]
    partitions = [_box(random, (0.8, 1.8), (0.04, 0.06), _nearly_square(random)) for _ in range(random.integers(1, 4))]
    return np.concatenate([room(random), *desks, *cupboards, *partitions])


FAMILIES: Final[dict[str, Callable[[np.random.Generator], FloatArray]]] = {
    "corridor": corridor,
    "clutter": clutter,
    "office": office,
    "room": room,
}


def cast_beams(
    walls: FloatArray, T_map_laser: Pose2D, bearings: NDArray[np.floating[Any]]
) -> tuple[FloatArray, IntArray]:
    """Return the distance to the first of the walls (W, 2, 2) along each beam (N,), and the wall's index.

    Metres, inf for none.
    """
    beams = unit_vectors(bearings + T_map_laser.theta)[:, None]
    start, along = walls[None, :, 0] - T_map_laser.translation, (walls[:, 1] - walls[:, 0])[None]
    with np.errstate(divide="ignore", invalid="ignore"):  # a beam parallel to a wall does not hit it
        facing = _cross(beams, along)
        distance, share = _cross(start, along) / facing, _cross(start, beams) / facing
        hit = (distance > 0) & (share >= 0) & (share <= 1)
    distance = np.where(hit, distance, np.inf)
    wall = np.argmin(distance, axis=1)
    return distance[np.arange(len(wall)), wall], wall


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the z component of the cross product over the last axis."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _recessed(random: np.random.Generator) -> FloatArray:
    """One side of the corridor along y = 0: walls with recesses towards positive y."""
    x = -6.0 + random.uniform(0.0, 1.5)
    corners = [(-6.0, 0.0)]
    while x < 5.0:
        door, depth = random.uniform(0.8, 1.3), random.uniform(0.12, 0.5)
        corners += [(x, 0.0), (x, depth), (x + door, depth), (x + door, 0.0)]
        x += door + random.uniform(0.8, 2.5)
    return np.array(list(pairwise([*corners, (x, 0.0)])))


def _nearly_square(random: np.random.Generator) -> float:
    return float(random.integers(2) * np.pi / 2 + random.normal(0.0, 0.03))


def _box(
    random: np.random.Generator, lengths: tuple[float, float], widths: tuple[float, float], yaw: float
) -> FloatArray:
    """Return a box in any direction from the sensor, at least CLEARANCE away, with sides drawn from these intervals."""
    length, width = random.uniform(*lengths), random.uniform(*widths)
    nearest = CLEARANCE + np.hypot(length, width) / 2
    bearing, distance = random.uniform(-np.pi, np.pi), random.uniform(nearest, nearest + 2.0)
    center = (float(distance * np.cos(bearing)), float(distance * np.sin(bearing)))
    return _outline(rectangle(center, length, width, yaw))


def _outline(corners: FloatArray) -> FloatArray:
    """Return the walls of the closed polygon with these corners (N, 2)."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
