"""A large floor plan: blocks of rooms with corridors between them, and a walk through its corridors."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np

from slam.pose import FloatArray, Pose2D

_BLOCKS: Final = (5, 4)
"""Blocks along x and along y."""
_BLOCK: Final = (12.0, 50.0)
"""Least and largest side of a block, metres."""
_SHIFT: Final = 2.5
"""Largest shift of a crossing in x and in y, metres, so that few corridors are parallel."""
_CORRIDOR: Final = (2.0, 4.5)
"""Least and largest width of a corridor, metres."""
_WALL: Final = 0.15
"""Thickness of the walls that doors lead through, metres."""
_DOOR: Final = 0.9
"""Width of a door, metres."""
_KINDS: Final = ("recess", "bay", "room")
_LENGTHS: Final = {"recess": (0.9, 1.3), "bay": (1.5, 5.0), "room": (2.0, 5.0)}
"""Least and largest length of a room along the corridor, metres."""
_DEPTHS: Final = {"recess": (0.1, 0.4), "bay": (0.5, 3.0), "room": (2.0, 4.5)}
"""Least and largest depth of a room behind the corridor's wall, metres."""
_BETWEEN: Final = (0.4, 4.0)
"""Least and largest length of plain wall between two rooms, metres."""

Node = tuple[int, int]
"""A crossing: indices of the corridors along y and along x that meet there."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockPlan:
    """Walls, and the centre lines of the corridors between the blocks."""

    walls: FloatArray
    """(W, 2, 2): start and end, metres."""
    crossings: FloatArray
    """(NX, NY, 2): positions of the crossings."""

    def neighbours(self, node: Node) -> list[Node]:
        """Return the next crossing along each corridor from this one."""
        i, k = node
        around = [(i - 1, k), (i + 1, k), (i, k - 1), (i, k + 1)]
        columns, rows, _ = self.crossings.shape
        return [(i, k) for i, k in around if 0 <= i < columns and 0 <= k < rows]


def make_block_plan(random: np.random.Generator) -> BlockPlan:
    """Draw the blocks, the corridors between and around them, and the rooms, bays and recesses in all walls."""
    (x, x_half), (y, y_half) = (_corridors(count, random) for count in _BLOCKS)
    crossings = np.stack(np.meshgrid(x, y, indexing="ij"), axis=2)
    crossings += random.uniform(-_SHIFT, _SHIFT, crossings.shape)
    halves = np.stack(np.meshgrid(x_half, y_half, indexing="ij"), axis=2)
    outlines = [_outside(crossings, halves), *_insides(crossings, halves)]
    sides = [_side(a, b, random) for outline in outlines for a, b in pairwise([*outline, outline[0]])]
    return BlockPlan(np.concatenate(sides), crossings)


def walk(plan: BlockPlan, length: float, random: np.random.Generator) -> FloatArray:
    """Walk at least ``length`` metres from crossing to crossing, (N, 2), by the least used corridors.

    The walk makes no U-turn.
    """
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
        left -= float(np.linalg.norm(plan.crossings[path[-1]] - plan.crossings[node]))
    return np.array([plan.crossings[node] for node in path])


def _corridors(blocks: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw the middles and half the widths (blocks + 1,) of parallel corridors, metres."""
    widths, gaps = random.uniform(*_CORRIDOR, blocks + 1), random.uniform(*_BLOCK, blocks)
    steps = gaps + (widths[:-1] + widths[1:]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)]), widths / 2.0


def _insides(crossings: FloatArray, halves: FloatArray) -> Iterator[FloatArray]:
    """Outlines (4, 2) of the blocks, counter-clockwise: the corners of the corridors around each."""
    for i, k in product(*map(range, _BLOCKS)):
        corners = [((i, k), (1, 1)), ((i + 1, k), (-1, 1)), ((i + 1, k + 1), (-1, -1)), ((i, k + 1), (1, -1))]
        yield np.array([crossings[at] + halves[at] * out for at, out in corners])


def _outside(crossings: FloatArray, halves: FloatArray) -> FloatArray:
    """Return the outline (N, 2) of the outer wall, clockwise; it has a corner beside every outer crossing."""
    (columns, rows), corners = np.add(_BLOCKS, 1), []
    ring = [
        *((0, k) for k in range(rows - 1)), *((i, rows - 1) for i in range(columns - 1)),
        *((columns - 1, k) for k in range(rows - 1, 0, -1)), *((i, 0) for i in range(columns - 1, 0, -1)),
    ]  # fmt: skip
    for i, k in ring:
        out = np.array([(i == columns - 1) - float(i == 0), (k == rows - 1) - float(k == 0)])
        corners.append(crossings[i, k] + halves[i, k] * out)
    return np.array(corners)


def _side(begin: FloatArray, end: FloatArray, random: np.random.Generator) -> FloatArray:
    """Return the walls (W, 2, 2) from one corner to the next, with the rooms behind them, to the left."""
    vector = end - begin
    length = float(np.hypot(*vector))
    T_map_side = Pose2D(float(begin[0]), float(begin[1]), float(np.arctan2(vector[1], vector[0])))
    outline = [(0.0, 0.0)]
    x = random.uniform(*_BETWEEN)
    while True:
        kind = _KINDS[random.integers(len(_KINDS))]
        high = x + random.uniform(*_LENGTHS[kind])
        if high > length - _BETWEEN[0]:
            break
        depth = min(random.uniform(*_DEPTHS[kind]), x, length - high)  # rooms of two sides do not overlap at a corner
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
