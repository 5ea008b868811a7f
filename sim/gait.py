"""The gait of people on their way-points: one foot stands while the other swings. Metres, seconds, map frame."""

from math import floor, hypot
from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.pose import FloatArray

LEG_HEIGHT: Final = 0.85
"""Height of people's legs, metres; people have no other parts, so a lidar above this does not see them."""


@compiled
def point_on(nodes: FloatArray, distances: FloatArray, walked: float) -> tuple[float, float, float, float]:
    """Return the point on a closed path after ``walked`` metres (x, y), and the direction there (unit x, y).

    ``nodes`` (K, 2) begins and ends with the same point; ``distances`` (K,) are the metres to each, from 0.
    """
    total = distances[-1]
    if total == 0.0:
        return nodes[0, 0], nodes[0, 1], 1.0, 0.0
    at = walked - total * floor(walked / total)
    k = min(max(np.searchsorted(distances, at, side="right") - 1, 0), len(distances) - 2)
    length = distances[k + 1] - distances[k]
    ux, uy = (nodes[k + 1, 0] - nodes[k, 0]) / length, (nodes[k + 1, 1] - nodes[k, 1]) / length
    return nodes[k, 0] + (at - distances[k]) * ux, nodes[k, 1] + (at - distances[k]) * uy, ux, uy


@compiled
def legs_at(nodes: FloatArray, distances: FloatArray, walked: float, stance: float, stride: float) -> FloatArray:
    """Return the middles of the left and the right leg, (2, 2), of a person after ``walked`` metres.

    In every stride one foot stands half a stride ahead of the start of the stride, on its side of the path; the other
    swings straight to its next stand, with a smooth start and end. No leg ever jumps, not even at a corner of the path.
    """
    legs = np.empty((2, 2))
    begun = floor(walked / stride) if distances[-1] > 0.0 else 0
    share = walked / stride - begun if distances[-1] > 0.0 else 0.5
    swung = share * share * (3.0 - 2.0 * share)
    for leg in range(2):
        side = stance / 2.0 if leg == 0 else -stance / 2.0
        if (begun + leg) % 2 == 0:  # this foot stands
            x, y, ux, uy = point_on(nodes, distances, (begun + 0.5) * stride)
            legs[leg, 0], legs[leg, 1] = x - side * uy, y + side * ux
        else:
            x, y, ux, uy = point_on(nodes, distances, (begun - 0.5) * stride)
            to_x, to_y, vx, vy = point_on(nodes, distances, (begun + 1.5) * stride)
            legs[leg, 0] = (1.0 - swung) * (x - side * uy) + swung * (to_x - side * vy)
            legs[leg, 1] = (1.0 - swung) * (y + side * ux) + swung * (to_y + side * vx)
    return legs


@compiled
def walk(
    nodes: FloatArray, distances: FloatArray, walked: float, rest: float,
    speed: float, pause: float, keep: float, robot: tuple[float, float], seconds: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the metres walked and the remaining rest, ``seconds`` later.

    A person rests ``pause`` seconds at each node, and takes no step while the robot is ahead and nearer than ``keep``.
    """
    if rest > 0.0:
        return walked, max(rest - seconds, 0.0)
    x, y, ux, uy = point_on(nodes, distances, walked)
    dx, dy = robot[0] - x, robot[1] - y
    if distances[-1] == 0.0 or (hypot(dx, dy) < keep and dx * ux + dy * uy > 0.0):
        return walked, 0.0
    turns = floor((walked + 1e-9) / distances[-1])
    at = walked - turns * distances[-1]
    ahead = distances[min(np.searchsorted(distances, at + 1e-9, side="right"), len(distances) - 1)] - at
    if pause > 0.0 and speed * seconds >= ahead - 1e-9:
        return walked + ahead, pause
    return walked + speed * seconds, 0.0


@compiled
def walk_all(
    nodes: FloatArray, distances: FloatArray, node_counts: NDArray[np.int64], habits: FloatArray, state: FloatArray,
    robot: tuple[float, float], seconds: float, positions: FloatArray, legs: FloatArray,
) -> None:  # fmt: skip
    """Move P people for ``seconds``, and write their positions.

    Their paths are rows of ``nodes`` (P, K, 2) and ``distances`` (P, K), as long as ``node_counts`` (P,) says;
    ``habits`` (P, 5) are speed, pause, keep, stance, stride; ``state`` (P, 2) is the metres walked and the remaining
    rest. The function writes ``state``, ``positions`` (P, 2) and ``legs`` (P, 2, 2).
    """
    for p in range(len(state)):
        path, at = nodes[p, : node_counts[p]], distances[p, : node_counts[p]]
        speed, pause, keep, stance, stride = habits[p]
        if seconds > 0.0:
            state[p, 0], state[p, 1] = walk(
                path, at, state[p, 0], state[p, 1], speed, pause, keep, robot, seconds
            )  # fmt: skip
        positions[p, 0], positions[p, 1], _, _ = point_on(path, at, state[p, 0])
        legs[p] = legs_at(path, at, state[p, 0], stance, stride)
