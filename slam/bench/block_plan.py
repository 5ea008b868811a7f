"""A large floor plan: blocks of rooms with corridors between them, and a walk through its corridors."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np

from slam.pose import FloatArray, Pose2D

_BLOCKS: Final = (6, 5)
"""Blocks along x and along y."""
_BLOCK: Final = (12.0, 30.0)
"""Least and largest side of a block, metres."""
_CORRIDOR: Final = (2.0, 4.5)
"""Least and largest width of a corridor, metres."""
_WALL: Final = 0.15
"""Thickness of the walls that doors lead through, metres."""
_DOOR: Final = 0.9
"""Width of a door, metres."""
_KINDS: Final = ("recess", "bay", "room")
_LENGTHS: Final = {"recess": (0.9, 1.3), "bay": (1.5, 5.0), "room": (2.0, 5.0)}
"""Least and largest length along the corridor, metres ..."""
_DEPTHS: Final = {"recess": (0.1, 0.4), "bay": (0.5, 3.0), "room": (2.0, 4.5)}
"""... and depth behind its wall."""
_BETWEEN: Final = (0.4, 4.0)
"""Least and largest length of plain wall between two of them, metres."""

Node = tuple[int, int]
"""Numbers of the corridors along y and along x that cross there."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockPlan:
    """Walls, and the middle lines of the corridors between the blocks."""

    walls: FloatArray
    """(W, 2, 2): start and end, metres."""
    x: FloatArray
    """Of the corridors along y, (NX,) ..."""
    y: FloatArray
    """... and y of those along x, (NY,)."""

    def place(self, node: Node) -> FloatArray:
        """Return where two corridors cross, (2,)."""
        return np.array([self.x[node[0]], self.y[node[1]]])

    def neighbours(self, node: Node) -> list[Node]:
        """List the crossings that a corridor leads to without another between."""
        i, k = node
        around = [(i - 1, k), (i + 1, k), (i, k - 1), (i, k + 1)]
        return [(i, k) for i, k in around if 0 <= i < len(self.x) and 0 <= k < len(self.y)]


def make_block_plan(random: np.random.Generator) -> BlockPlan:
    """Draw the blocks, the corridors between and around them, and the rooms, bays and recesses in all walls."""
    (x_low, x_high), (y_low, y_high) = (_corridors(count, random) for count in _BLOCKS)
    corners = [_corners(x_high[i], y_high[k], x_low[i + 1], y_low[k + 1]) for i, k in product(*map(range, _BLOCKS))]
    outside = _corners(x_low[0], y_low[0], x_high[-1], y_high[-1])[::-1]
    walls = [_side(begin, end, random) for c in (outside, *corners) for begin, end in pairwise([*c, c[0]])]
    return BlockPlan(np.concatenate(walls), (x_low + x_high) / 2.0, (y_low + y_high) / 2.0)


def walk(plan: BlockPlan, length: float, random: np.random.Generator) -> FloatArray:
    """Walk at least ``length`` metres from crossing to crossing, (N, 2): where it was least, never straight back."""
    path: list[Node] = [(0, 0)]
    walked: Counter[frozenset[Node]] = Counter()
    left = length
    while left > 0.0:
        node = path[-1]
        onwards = [other for other in plan.neighbours(node) if len(path) < 2 or other != path[-2]]
        least = min(walked[frozenset((node, other))] for other in onwards)
        fresh = [other for other in onwards if walked[frozenset((node, other))] == least]
        path.append(fresh[random.integers(len(fresh))])
        walked[frozenset((node, path[-1]))] += 1
        left -= float(np.linalg.norm(plan.place(path[-1]) - plan.place(node)))
    return np.array([plan.place(node) for node in path])


def _corridors(blocks: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw the lower and the upper bounds (blocks + 1,) of the corridors that lie one beside the other, metres."""
    widths, gaps = random.uniform(*_CORRIDOR, blocks + 1), random.uniform(*_BLOCK, blocks)
    low = np.concatenate([[0.0], np.cumsum(widths[:-1] + gaps)])
    return low, low + widths


def _corners(x_low: float, y_low: float, x_high: float, y_high: float) -> FloatArray:
    """Corners (4, 2) of a rectangle, counter-clockwise."""
    return np.array([[x_low, y_low], [x_high, y_low], [x_high, y_high], [x_low, y_high]])


def _side(begin: FloatArray, end: FloatArray, random: np.random.Generator) -> FloatArray:
    """The walls (W, 2, 2) from one corner to the next, with what lies behind them, to the left."""
    way = end - begin
    length = float(np.hypot(*way))
    T_map_side = Pose2D(float(begin[0]), float(begin[1]), float(np.arctan2(way[1], way[0])))
    outline = [(0.0, 0.0)]
    x = random.uniform(*_BETWEEN)
    while True:
        kind = _KINDS[random.integers(len(_KINDS))]
        high = x + random.uniform(*_LENGTHS[kind])
        if high > length - _BETWEEN[0]:
            break
        depth = min(random.uniform(*_DEPTHS[kind]), x, length - high)  # two sides share their corner at 45 degrees
        outline += _room(x, high, depth, random) if kind == "room" else [(x, 0.0), (x, depth), (high, depth), (high, 0)]
        x = high + random.uniform(*_BETWEEN)
    points = T_map_side.transform(np.array([*outline, (length, 0.0)]))
    return np.stack([points[:-1], points[1:]], axis=1)


def _room(low: float, high: float, depth: float, random: np.random.Generator) -> list[tuple[float, float]]:
    """Outline of a room behind an open door."""
    begin = random.uniform(low, high - _DOOR)
    end, inner = begin + _DOOR, min(_WALL, depth)
    return [
        (begin, 0.0), (begin, inner), (low, inner), (low, depth), (high, depth), (high, inner), (end, inner), (end, 0.0)
    ]  # fmt: skip
