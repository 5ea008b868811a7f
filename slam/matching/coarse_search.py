"""Correlative search, compiled: every pose of a window is tried for a scan.

The map near the scan is drawn into nine pictures, one for each of eight directions that a wall may face and one for
clusters, which are surfels without a normal. So a facet is supported only by walls with a similar normal. For every
heading the pictures, each shifted by a facet, are summed over the whole window at once. After Olson, "Real-time
correlative scan matching", ICRA 2009.
"""

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.lines.facets import NX, NY, X, Y
from slam.mapping.surfel_grid import Grid
from slam.pose import FloatArray

SCORE, PLACE_X, PLACE_Y, HEADING = range(4)
"""Columns of the poses (N, 4) that a search finds."""
SIDES = 8  # directions that a wall may face
CLUSTER_PICTURE = 8  # the number of the picture of clusters
FULL_GREY = 63.0  # grey value on a wall: 1000 facets fit into 16 bits
PIXEL = 0.10  # metres, the side of a pixel
BLUR = 0.15  # metres from a wall beyond which the grey value is 0
HEADING_STEP = 0.02  # radians from one heading to the next


@compiled
def correlative_search(
    facets: FloatArray, prior: FloatArray, information: FloatArray, half_width: float, half_angle: float, reach: float,
    grid: Grid,
) -> FloatArray:  # fmt: skip
    """Return the best position for every heading, (A, 4); the score counts facets on walls.

    ``information`` (3, 3) is the prior's, already weighted: half the squared Mahalanobis distance is subtracted.
    """
    n, m = int(np.ceil(half_width / PIXEL)), int(np.ceil(half_angle / HEADING_STEP))
    size = 2 * (int(reach / PIXEL) + n + 2)
    x0, y0 = prior[0] - 0.5 * size * PIXEL, prior[1] - 0.5 * size * PIXEL
    pictures = draw(grid, x0, y0, size)
    best, scores = np.empty((2 * m + 1, 4)), np.empty((2 * n + 1, 2 * n + 1), np.uint16)
    half = 0.5 * information
    xx, xy, yy, xt = half[0, 0], half[0, 1], half[1, 1], 2.0 * half[0, 2] * HEADING_STEP
    yt, tt = 2.0 * half[1, 2] * HEADING_STEP, half[2, 2] * HEADING_STEP * HEADING_STEP
    for a in range(-m, m + 1):
        theta = prior[2] + a * HEADING_STEP
        _add_up(facets, prior[0] - x0, prior[1] - y0, theta, reach, pictures, scores)
        best[a + m, SCORE] = -np.inf
        for i in range(2 * n + 1):
            for j in range(2 * n + 1):
                dx, dy = (j - n) * PIXEL, (i - n) * PIXEL
                cost = dx * (xx * dx + 2.0 * xy * dy + xt * a) + dy * (yy * dy + yt * a) + tt * a * a
                score = scores[i, j] / FULL_GREY - cost if scores[i, j] > 0 else -np.inf
                if score > best[a + m, SCORE]:
                    best[a + m, SCORE] = score
                    best[a + m, PLACE_X], best[a + m, PLACE_Y] = prior[0] + dx, prior[1] + dy
        best[a + m, HEADING] = theta
    return best


@compiled
def draw(grid: Grid, x0: float, y0: float, size: int) -> NDArray[np.uint8]:
    """Draw the pictures (9, size, size) of the map, their lower left corner at (x0, y0), one pixel PIXEL wide."""
    pictures = np.zeros((SIDES + 1, size, size), np.uint8)
    rows, columns = grid.head.shape
    low_row, low_column = int(np.floor(y0 / grid.cell)) - grid.corner[0], int(np.floor(x0 / grid.cell)) - grid.corner[1]
    span = int(size * PIXEL / grid.cell) + 2
    for row in range(max(low_row, 0), min(low_row + span, rows)):
        for column in range(max(low_column, 0), min(low_column + span, columns)):
            k = grid.head[row, column]
            while k >= 0:
                _draw_one(pictures, grid.surfels[k], x0, y0, 0.5 * grid.cell)
                k = grid.next[k]
    return pictures


@compiled_on_views
def _draw_one(pictures: NDArray[np.uint8], s: FloatArray, x0: float, y0: float, half: float) -> None:
    """Draw a surfel into the pictures of the two directions next to its normal."""
    size = pictures.shape[1]
    wall = s[NX] != 0.0 or s[NY] != 0.0
    first = second = CLUSTER_PICTURE
    if wall:
        first = int(np.floor(np.arctan2(s[NY], s[NX]) * SIDES / (2.0 * np.pi))) % SIDES
        second = (first + 1) % SIDES
    i0, j0, span = int((s[Y] - y0) / PIXEL), int((s[X] - x0) / PIXEL), int((half + BLUR) / PIXEL) + 1
    for i in range(max(i0 - span, 0), min(i0 + span + 1, size)):
        for j in range(max(j0 - span, 0), min(j0 + span + 1, size)):
            dx, dy = x0 + (j + 0.5) * PIXEL - s[X], y0 + (i + 0.5) * PIXEL - s[Y]
            across = abs(dx * s[NX] + dy * s[NY]) if wall else np.sqrt(dx * dx + dy * dy)
            if across < BLUR and (not wall or abs(dx * s[NY] - dy * s[NX]) < half + 0.5 * PIXEL):
                grey = np.uint8(FULL_GREY * (1.0 - (across / BLUR) ** 2))
                pictures[first, i, j] = max(pictures[first, i, j], grey)
                pictures[second, i, j] = max(pictures[second, i, j], grey)


@compiled_on_views
def layer_of(nx: float, ny: float, c: float, s: float) -> int:
    """Return the picture for a facet with this normal in the sensor frame.

    The sensor's heading has cosine c and sine s.
    """
    if nx == 0.0 and ny == 0.0:
        return CLUSTER_PICTURE
    bearing = np.arctan2(s * nx + c * ny, c * nx - s * ny)
    return int(np.floor(bearing * SIDES / (2.0 * np.pi) + 0.5)) % SIDES


@compiled_on_views
def _add_up(
    facets: FloatArray, x: float, y: float, theta: float, reach: float, pictures: NDArray[np.uint8],
    scores: NDArray[np.uint16],
) -> None:  # fmt: skip
    """Sum the grey values under all facets for every shift of the window about (x, y), metres in the pictures."""
    c, s = np.cos(theta), np.sin(theta)
    n = len(scores) // 2
    scores[:] = 0
    for f in range(len(facets)):
        fx, fy, fnx, fny = facets[f, X], facets[f, Y], facets[f, NX], facets[f, NY]
        if fx * fx + fy * fy >= reach * reach:
            continue
        side = layer_of(fnx, fny, c, s)
        i0 = int(np.floor((y + s * fx + c * fy) / PIXEL)) - n
        j0 = int(np.floor((x + c * fx - s * fy) / PIXEL)) - n
        for i in range(len(scores)):
            for j in range(len(scores)):
                scores[i, j] += pictures[side, i0 + i, j0 + j]
