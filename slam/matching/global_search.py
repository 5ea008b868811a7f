"""Search of the whole map for a scan, without a prior, compiled: every position and every heading is tried.

The pictures of the map are those of coarse_search.py. Each is also pooled, so that a pixel holds the greatest grey
value of a block: these give an upper bound of the score for a heading and a block of positions, and only the blocks
with the highest bounds are evaluated (the bound of branch and bound, after Hess et al., "Real-time loop closure in 2D
lidar SLAM", ICRA 2016; here many poses are wanted, and not only the best one).
"""

from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views, wrapped
from slam.lines.facets import NX, NY, X, Y
from slam.lines.segments import IntArray
from slam.mapping.surfel_grid import Grid
from slam.mapping.surfel_map import SurfelMap
from slam.matching.coarse_search import FULL_GREY, HEADING, PIXEL, PLACE_X, PLACE_Y, SCORE, draw, layer_of
from slam.pose import FloatArray

BLOCK = 4  # pixels along a side of a block
HEADINGS: Final = 160
"""Number of headings: 0.04 rad apart."""
MAX_BLOCKS: Final = 4000
"""Number of blocks that are searched, those with the highest bounds."""
MIN_DISTANCE, MIN_ANGLE = 0.4, 0.2
"""Two poses are different if they are this far apart: metres and radians."""
REACH: Final = 15.0
"""Distance from the sensor, metres, beyond which pieces of the scan are ignored."""
MAX_FACETS: Final = 300
"""Largest number of facets of a scan: grey values of more do not fit into 16 bits."""
PICTURE, ROWS, COLUMNS = range(3)
"""Columns of shifts (F, 3): picture in which a facet searches its wall, and its pixels from the laser."""

Pictures = NDArray[np.uint8]


class GlobalSearch:
    """The pictures of the map for positions from ``low`` to ``high`` (2,); the map must not change any more."""

    def __init__(self, grid: Grid, low: FloatArray, high: FloatArray) -> None:
        self._low = low - REACH - 1.0
        columns, rows = (np.ceil((high - low) / (BLOCK * PIXEL)).astype(np.int64) + 1).tolist()
        self._shape = HEADINGS, rows, columns  # numbers of headings, and of blocks along y and x
        size = int(np.ceil((high - low).max() / PIXEL)) + 2 * int((REACH + 1.0) / PIXEL) + 2 * BLOCK
        self._first = round((REACH + 1.0) / PIXEL)  # row and column of pixels where the laser may be
        self._pictures = draw(grid, float(self._low[0]), float(self._low[1]), size)
        self._pooled = _pooled(self._pictures)

    @classmethod
    def of_map(cls, surfel_map: SurfelMap) -> Self:
        """Search the whole map."""
        centres = surfel_map.points if len(surfel_map) else np.zeros((1, 2))
        return cls(surfel_map.grid, centres.min(axis=0), centres.max(axis=0))

    def places(self, facets: FloatArray, most: int) -> FloatArray:
        """Return up to ``most`` different poses of the laser, (N, 4), the best first.

        The score is the share of facets on walls, of all (F, 7) within range.
        """
        near = np.ascontiguousarray(facets[np.hypot(facets[:, X], facets[:, Y]) < REACH])
        near = near[:: len(near) // MAX_FACETS + 1]
        if not len(near):
            return np.empty((0, 4))
        bounds = _bounds(near, self._first, self._shape, self._pooled).ravel()
        blocks = np.argpartition(-bounds.astype(np.int32), min(MAX_BLOCKS, bounds.size - 1))[:MAX_BLOCKS]
        found = _best_of_blocks(near, self._first, self._shape, np.sort(blocks), self._pictures)
        found[:, SCORE] /= FULL_GREY * len(near)
        found[:, [PLACE_X, PLACE_Y]] = self._low + (found[:, [PLACE_X, PLACE_Y]] + 0.5) * PIXEL
        return _distinct(found[np.argsort(-found[:, SCORE], kind="stable")], most)


def _pooled(pictures: Pictures) -> Pictures:
    """Return the greatest value of the block that begins at each pixel."""
    across = pictures.copy()
    for d in range(1, BLOCK):
        np.maximum(across[:, :, :-d], pictures[:, :, d:], out=across[:, :, :-d])
    pooled = across.copy()
    for d in range(1, BLOCK):
        np.maximum(pooled[:, :-d], across[:, d:], out=pooled[:, :-d])
    return pooled


@compiled_on_views
def _shift(facet: FloatArray, theta: float) -> tuple[int, int, int]:
    """Return picture, rows and columns from the laser, of a facet for this heading of the laser."""
    c, s = np.cos(theta), np.sin(theta)
    di = int(np.floor((s * facet[X] + c * facet[Y]) / PIXEL + 0.5))
    dj = int(np.floor((c * facet[X] - s * facet[Y]) / PIXEL + 0.5))
    return layer_of(facet[NX], facet[NY], c, s), di, dj


@compiled
def _bounds(facets: FloatArray, first: int, shape: tuple[int, int, int], pooled: Pictures) -> NDArray[np.uint16]:
    """Return the upper bound of the score for every heading and block of positions: headings, rows, columns."""
    headings, rows, columns = shape
    bounds = np.zeros(shape, np.uint16)
    for a in range(headings):
        for f in range(len(facets)):
            side, di, dj = _shift(facets[f], a * 2.0 * np.pi / headings)
            for i in range(rows):
                line = pooled[side, first + i * BLOCK + di]
                for j in range(columns):
                    bounds[a, i, j] += line[first + j * BLOCK + dj]
    return bounds


@compiled
def _best_of_blocks(
    facets: FloatArray, first: int, shape: tuple[int, int, int], blocks: IntArray, pictures: Pictures
) -> FloatArray:
    """Return the best pose of each of these blocks (B,), numbered as in ``_bounds``: (B, 4), x and y in pixels."""
    headings, rows, columns = shape
    found = np.zeros((len(blocks), 4))
    shifts = np.empty((len(facets), 3), np.int64)
    last = -1
    for b in range(len(blocks)):
        a, place = blocks[b] // (rows * columns), blocks[b] % (rows * columns)
        i0, j0 = first + place // columns * BLOCK, first + place % columns * BLOCK
        theta = a * 2.0 * np.pi / headings
        if a != last:
            last = a
            for f in range(len(facets)):
                shifts[f, PICTURE], shifts[f, ROWS], shifts[f, COLUMNS] = _shift(facets[f], theta)
        found[b, SCORE] = -1.0
        for i in range(i0, i0 + BLOCK):
            for j in range(j0, j0 + BLOCK):
                score = 0.0
                for f in range(len(facets)):
                    score += pictures[shifts[f, PICTURE], i + shifts[f, ROWS], j + shifts[f, COLUMNS]]
                if score > found[b, SCORE]:
                    found[b, SCORE], found[b, PLACE_X], found[b, PLACE_Y], found[b, HEADING] = score, j, i, theta
    return found


@compiled
def _distinct(rows: FloatArray, most: int) -> FloatArray:
    """Return the poses (N, 4), sorted by score, without those near a better one; ``most`` at most."""
    chosen, count = np.empty((most, 4)), 0
    for k in range(len(rows)):
        alone = count < most
        for other in range(count):
            turn = wrapped(rows[k, HEADING] - chosen[other, HEADING])
            dx, dy = rows[k, PLACE_X] - chosen[other, PLACE_X], rows[k, PLACE_Y] - chosen[other, PLACE_Y]
            alone = alone and not (np.hypot(dx, dy) < MIN_DISTANCE and abs(turn) < MIN_ANGLE)
        if alone:
            chosen[count] = rows[k]
            count += 1
    return chosen[:count]
