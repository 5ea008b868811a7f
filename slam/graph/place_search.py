"""Branch-and-bound search of a pose in a submap, compiled: all poses of a window get upper bounds, few are evaluated.

The pictures of the submap are those of coarse_search.py. Pooled over blocks of pixels they give, for a heading and a
block of positions, an upper bound of the score of a joint scan; the blocks with the highest bounds, minus the cost of
the prior, are evaluated (after Hess et al., "Real-time loop closure in 2D lidar SLAM", ICRA 2016).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views, wrapped
from slam.lines.facets import NX, NY, X, Y
from slam.lines.segments import IntArray
from slam.mapping.surfel_grid import Grid
from slam.matching.coarse_search import FULL_GREY, HEADING, HEADING_STEP, PIXEL, PLACE_X, PLACE_Y, SCORE, draw, layer_of
from slam.pose import FloatArray

BLOCK = 4  # pixels along a side of a block
MAX_BLOCKS = 400  # blocks that are searched
MIN_DISTANCE, MIN_ANGLE = 0.4, 0.1  # two poses are different if they are this far apart: metres and radians


class Window(NamedTuple):
    """The window of poses that are tried."""

    prior: FloatArray
    """(3,): middle of the window."""
    information: FloatArray
    """(3, 3): information of the prior. Half the squared Mahalanobis distance is subtracted from the score, which is 1
    if all facets lie on walls."""
    half_width: int
    """Half the width, pixels."""
    half_headings: int
    """Half the number of headings."""

    @classmethod
    def about(cls, prior: FloatArray, information: FloatArray, width: float, angle: float) -> "Window":
        """Make the window with this half width, metres and radians."""
        return cls(prior, information, int(np.ceil(width / PIXEL)), int(np.ceil(angle / HEADING_STEP)))


class Pictures(NamedTuple):
    """A submap in the form that find_places searches."""

    drawn: NDArray[np.uint8]
    """(9, rows, columns): grey values, see coarse_search.py."""
    pooled: NDArray[np.uint8]
    """(9, BLOCK, rows, columns / BLOCK): greatest value of the block that begins at each pixel, columns sorted by their
    remainder, so that the blocks of a window lie side by side."""
    x0: float
    """Lower left corner, metres, in the frame of the submap's map."""
    y0: float


def draw_submap(grid: Grid, path: FloatArray, reach: float) -> Pictures:
    """Draw everything within ``reach`` of a path (K, 3)."""
    low, high = path[:, :2].min(axis=0) - reach, path[:, :2].max(axis=0) + reach
    size = int(np.ceil((high - low).max() / PIXEL)) + BLOCK
    drawn = draw(grid, float(low[0]), float(low[1]), size)
    return Pictures(drawn, _pooled(drawn), float(low[0]), float(low[1]))


def find_places(facets: FloatArray, window: Window, pictures: Pictures, least: float, most: int) -> FloatArray:
    """Find up to ``most`` different poses, (N, 4), the best first.

    At each, at least the share ``least`` of the facets (F, 7) lies on walls. SCORE is that share minus the cost of the
    prior.
    """
    blocks = (2 * window.half_width + BLOCK) // BLOCK
    shifts = _shifts(facets, window, pictures.x0, pictures.y0)
    bounds = _bounds(shifts, pictures, blocks)
    scores = _scores(bounds, window, len(facets), least)
    places, shares = _best_of_blocks(_highest(scores), blocks, shifts, pictures.drawn, window)
    best_first = np.argsort(-places[:, SCORE], kind="stable")
    return _distinct(places[best_first], shares[best_first], least, most)


def _pooled(pictures: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the greatest value of the block that begins at each pixel, see Pictures.

    Blocks at the far borders are smaller.
    """
    layers, rows, columns = pictures.shape
    wide, high = columns - BLOCK + 1, rows - BLOCK + 1
    along = pictures.copy()
    for d in range(1, BLOCK):
        np.maximum(along[:, :, :wide], pictures[:, :, d : d + wide], out=along[:, :, :wide])
    pooled = np.zeros((layers, rows, columns + -columns % BLOCK), np.uint8)
    pooled[:, :, :columns] = along
    for d in range(1, BLOCK):
        np.maximum(pooled[:, :high, :columns], along[:, d : d + high], out=pooled[:, :high, :columns])
    return np.ascontiguousarray(pooled.reshape(layers, rows, -1, BLOCK).transpose(0, 3, 1, 2))


@compiled
def _shifts(facets: FloatArray, window: Window, x0: float, y0: float) -> IntArray:
    """Return picture, row and column (A, F, 3) of each facet for every heading, at the first position of the window."""
    headings = 2 * window.half_headings + 1
    shifts = np.empty((headings, len(facets), 3), np.int64)
    for a in range(headings):
        theta = window.prior[2] + (a - window.half_headings) * HEADING_STEP
        c, s = np.cos(theta), np.sin(theta)
        for f in range(len(facets)):
            x = window.prior[0] - x0 + c * facets[f, X] - s * facets[f, Y]
            y = window.prior[1] - y0 + s * facets[f, X] + c * facets[f, Y]
            shifts[a, f, 0] = layer_of(facets[f, NX], facets[f, NY], c, s)
            shifts[a, f, 1] = int(np.floor(y / PIXEL)) - window.half_width
            shifts[a, f, 2] = int(np.floor(x / PIXEL)) - window.half_width
    return shifts


@compiled
def _bounds(shifts: IntArray, pictures: Pictures, blocks: int) -> NDArray[np.uint16]:
    """Return the upper bound of the grey values for every heading and block of positions, (A, blocks, blocks)."""
    bounds = np.zeros((len(shifts), blocks, blocks), np.uint16)
    _, rows, columns = pictures.drawn.shape
    for a in range(len(shifts)):
        for f in range(shifts.shape[1]):
            side, row, column = shifts[a, f]
            low_i, high_i = _inside(row, rows, blocks)
            low_j, high_j = _inside(column, columns, blocks)
            first = column // BLOCK + low_j
            for i in range(low_i, high_i):
                line = pictures.pooled[side, column % BLOCK, row + i * BLOCK, first:]
                _add_to(bounds[a, i, low_j:high_j], line)
    return bounds


@compiled_on_views
def _add_to(sums: NDArray[np.uint16], line: NDArray[np.uint8]) -> None:
    for k in range(len(sums)):
        sums[k] += line[k]


@compiled_on_views
def _inside(first: int, size: int, blocks: int) -> tuple[int, int]:
    """Return the range of blocks that begin inside the picture, if block 0 begins at pixel ``first``."""
    low = 0 if first >= 0 else (-first + BLOCK - 1) // BLOCK
    high = min(blocks, (size - 1 - first) // BLOCK + 1)
    return low, max(high, low)


@compiled
def _scores(bounds: NDArray[np.uint16], window: Window, facets: int, least: float) -> FloatArray:
    """Return the upper bounds of the scores of all blocks; -1e9 below ``least``."""
    scores = np.empty(bounds.size)
    angles, blocks, _ = bounds.shape
    k = 0
    for a in range(angles):
        for i in range(blocks):
            for j in range(blocks):
                middle = 0.5 * (BLOCK - 1) - window.half_width
                dx, dy = (j * BLOCK + middle) * PIXEL, (i * BLOCK + middle) * PIXEL
                share = bounds[a, i, j] / (FULL_GREY * facets)
                scores[k] = (
                    share - _cost(dx, dy, (a - window.half_headings) * HEADING_STEP, window) if share >= least else -1e9
                )
                k += 1
    return scores


def _highest(scores: FloatArray) -> IntArray:
    """Return the indices of the blocks with the highest scores."""
    kept = min(MAX_BLOCKS, len(scores) - 1)
    threshold = np.partition(scores, len(scores) - 1 - kept)[len(scores) - 1 - kept]
    return np.flatnonzero((scores > threshold) & (scores > -1e9))


@compiled
def _best_of_blocks(
    chosen: IntArray, blocks: int, shifts: IntArray, pictures: NDArray[np.uint8], window: Window
) -> tuple[FloatArray, FloatArray]:
    """Return the best pose of each block (N, 4), and the share of the facets on walls there (N,)."""
    places, shares = np.empty((len(chosen), 4)), np.empty(len(chosen))
    for b in range(len(chosen)):
        shares[b] = _best_of_block(chosen[b], blocks, shifts, pictures, window, places[b])
    return places, shares


@compiled_on_views
def _cost(dx: float, dy: float, turn: float, window: Window) -> float:
    """Return half the squared Mahalanobis distance from the prior."""
    L = window.information
    by_place = L[0, 0] * dx * dx + 2.0 * L[0, 1] * dx * dy + L[1, 1] * dy * dy
    return float(0.5 * (by_place + turn * (2.0 * L[0, 2] * dx + 2.0 * L[1, 2] * dy + L[2, 2] * turn)))


@compiled
def _best_of_block(
    block: int, blocks: int, shifts: IntArray, pictures: NDArray[np.uint8], window: Window, place: FloatArray
) -> float:
    """Write the best pose (4,) of a block; return the share of the facets on walls there."""
    a, first_i, first_j = block // (blocks * blocks), block // blocks % blocks * BLOCK, block % blocks * BLOCK
    turn, facets = (a - window.half_headings) * HEADING_STEP, shifts.shape[1]
    _, rows, columns = pictures.shape
    best_share, place[SCORE] = 0.0, -np.inf
    for i in range(first_i, min(first_i + BLOCK, 2 * window.half_width + 1)):
        for j in range(first_j, min(first_j + BLOCK, 2 * window.half_width + 1)):
            total = 0.0
            for f in range(facets):
                row, column = shifts[a, f, 1] + i, shifts[a, f, 2] + j
                if 0 <= row < rows and 0 <= column < columns:
                    total += pictures[shifts[a, f, 0], row, column]
            share = total / (FULL_GREY * facets)
            dx, dy = (j - window.half_width) * PIXEL, (i - window.half_width) * PIXEL
            score = share - _cost(dx, dy, turn, window)
            if score > place[SCORE]:
                best_share, place[SCORE] = share, score
                place[PLACE_X], place[PLACE_Y] = window.prior[0] + dx, window.prior[1] + dy
                place[HEADING] = window.prior[2] + turn
    return float(best_share)


@compiled
def _distinct(places: FloatArray, shares: FloatArray, least: float, most: int) -> FloatArray:
    """Return the poses (N, 4), sorted by score, without those near a better one; ``most`` at most."""
    chosen, count = np.empty((most, 4)), 0
    for k in range(len(places)):
        alone = shares[k] >= least and count < most
        for other in range(count):
            if not alone:
                break
            dx, dy = places[k, PLACE_X] - chosen[other, PLACE_X], places[k, PLACE_Y] - chosen[other, PLACE_Y]
            turn = abs(wrapped(places[k, HEADING] - chosen[other, HEADING]))
            alone = np.hypot(dx, dy) > MIN_DISTANCE or turn > MIN_ANGLE
        if alone:
            chosen[count] = places[k]
            count += 1
    return chosen[:count].copy()
