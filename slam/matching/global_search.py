"""Where in the whole map a scan could be, from nothing: every place and every heading, compiled.

The pictures of the map are those of coarse_search.py. Each is also pooled, so that a pixel holds the greatest grey
value of a block: with these, a heading and a block of places get an upper bound of their score at once, and only the
blocks with the highest bounds are looked into (the bound of branch and bound, after Hess et al., "Real-time loop
closure in 2D lidar SLAM", ICRA 2016; here many places are wanted, and not the best one alone).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, wrapped
from slam.mapping.surfel_map import SurfelMap
from slam.matching.coarse_search import FULL, PIXEL, draw, picture_of
from slam.pose import FloatArray

BLOCK = 4  # pixels along a side of a block
HEADINGS: Final = 160
"""Headings tried: 0.04 rad apart."""
OPENED: Final = 4000
"""Blocks that are looked into."""
APART: Final = 0.4, 0.2
"""Two places are different when they are so far apart: metres and radians."""
FARTHEST: Final = 15.0
"""Pieces of the scan farther than this take no part, metres."""
MOST_FACETS: Final = 300
"""Of a scan, that take part: grey values of more do not fit into 16 bits."""

Pictures = NDArray[np.uint8]


class GlobalSearch:
    """The pictures of one map, which must not change any more."""

    def __init__(self, surfel_map: SurfelMap) -> None:
        centres = surfel_map.points
        low, high = (centres.min(axis=0), centres.max(axis=0)) if len(centres) else (np.zeros(2), np.zeros(2))
        self._low = low - FARTHEST - 1.0
        self._blocks = np.ceil((high - low) / (BLOCK * PIXEL)).astype(np.int64) + 1
        size = int(np.ceil((high - low).max() / PIXEL)) + 2 * int((FARTHEST + 1.0) / PIXEL) + 2 * BLOCK
        self._first = np.array([round((FARTHEST + 1.0) / PIXEL)] * 2, np.int64)  # of the pixels where the laser may be
        self._pictures = draw(surfel_map.grid, float(self._low[0]), float(self._low[1]), size)
        self._pooled = _pooled(self._pictures)

    def places(self, facets: FloatArray, most: int) -> FloatArray:
        """Up to ``most`` poses of the laser, (N, 4): share of the facets (F, 7) that lie on walls, x, y, theta; the
        best first, and no two of them nearer than APART."""
        near = np.ascontiguousarray(facets[np.hypot(facets[:, 0], facets[:, 1]) < FARTHEST])
        near = near[:: len(near) // MOST_FACETS + 1]
        if not len(near):
            return np.empty((0, 4))
        bounds = _bounds(near, self._first, self._blocks[0], self._blocks[1], HEADINGS, self._pooled)
        flat = bounds.ravel()
        opened = np.argpartition(-flat.astype(np.int32), min(OPENED, flat.size - 1))[:OPENED]
        rows = _open(near, self._first, np.array(bounds.shape), np.sort(opened), self._pictures)
        rows[:, 0] /= FULL * len(near)
        rows[:, 1:3] = self._low + (rows[:, 1:3] + 0.5) * PIXEL
        return _apart(rows[np.argsort(-rows[:, 0], kind="stable")], most, *APART)


@compiled
def _pooled(pictures: Pictures) -> Pictures:
    """The greatest value of the block that begins at each pixel."""
    sides, rows, columns = pictures.shape
    across, pooled = pictures.copy(), pictures.copy()
    for p in range(sides):
        for i in range(rows):
            for j in range(columns):
                for d in range(1, min(BLOCK, columns - j)):
                    across[p, i, j] = max(across[p, i, j], pictures[p, i, j + d])
        for i in range(rows):
            for j in range(columns):
                value = across[p, i, j]
                for d in range(1, min(BLOCK, rows - i)):
                    value = max(value, across[p, i + d, j])
                pooled[p, i, j] = value
    return pooled


@compiled
def _shift(facet: FloatArray, theta: float) -> tuple[int, int, int]:
    """Picture, and rows and columns from the laser, of a facet when the laser heads there."""
    c, s = np.cos(theta), np.sin(theta)
    di = int(np.floor((s * facet[0] + c * facet[1]) / PIXEL + 0.5))
    dj = int(np.floor((c * facet[0] - s * facet[1]) / PIXEL + 0.5))
    return picture_of(facet[2], facet[3], c, s), di, dj


@compiled
def _bounds(
    facets: FloatArray, first: NDArray[np.int64], columns: int, rows: int, headings: int, pooled: Pictures
) -> NDArray[np.uint16]:
    """Upper bound of the score for every heading and block of places: (headings, rows, columns)."""
    bounds = np.zeros((headings, rows, columns), np.uint16)
    for a in range(headings):
        for f in range(len(facets)):
            side, di, dj = _shift(facets[f], a * 2.0 * np.pi / headings)
            for i in range(rows):
                line = pooled[side, first[1] + i * BLOCK + di]
                for j in range(columns):
                    bounds[a, i, j] += line[first[0] + j * BLOCK + dj]
    return bounds


@compiled
def _open(
    facets: FloatArray, first: NDArray[np.int64], shape: NDArray[np.int64], blocks: NDArray[np.int64],
    pictures: Pictures,
) -> FloatArray:  # fmt: skip
    """The best place of each of these blocks (B,): rows of score, column, row, heading (radians)."""
    found = np.zeros((len(blocks), 4))
    shifts = np.empty((len(facets), 3), np.int64)
    last = -1
    for b in range(len(blocks)):
        a, place = blocks[b] // (shape[1] * shape[2]), blocks[b] % (shape[1] * shape[2])
        i0, j0 = first[1] + place // shape[2] * BLOCK, first[0] + place % shape[2] * BLOCK
        theta = a * 2.0 * np.pi / shape[0]
        if a != last:
            last = a
            for f in range(len(facets)):
                shifts[f, 0], shifts[f, 1], shifts[f, 2] = _shift(facets[f], theta)
        found[b, 0] = -1.0
        for i in range(i0, i0 + BLOCK):
            for j in range(j0, j0 + BLOCK):
                score = 0.0
                for f in range(len(facets)):
                    score += pictures[shifts[f, 0], i + shifts[f, 1], j + shifts[f, 2]]
                if score > found[b, 0]:
                    found[b, 0], found[b, 1], found[b, 2], found[b, 3] = score, j, i, theta
    return found


@compiled
def _apart(rows: FloatArray, most: int, distance: float, angle: float) -> FloatArray:
    """Of rows (N, 4), the best first, those that lie near none before them; ``most`` at most."""
    chosen, count = np.empty((most, 4)), 0
    for k in range(len(rows)):
        alone = count < most
        for other in range(count):
            turn = wrapped(rows[k, 3] - chosen[other, 3])
            near = np.hypot(rows[k, 1] - chosen[other, 1], rows[k, 2] - chosen[other, 2]) < distance
            alone = alone and not (near and abs(turn) < angle)
        if alone:
            chosen[count] = rows[k]
            count += 1
    return chosen[:count]
