"""Walls as landmarks: the facets of all key scans, gathered into walls that are straight within about a centimetre.

Facets with similar normals are sorted into cells along the wall, and those of a cell that lie close together across it
form a piece. A wall grows from its heaviest piece over its neighbours, as long as these lie on its line. Where the wall
of the building bends or steps, the landmark ends and another one begins; its length does not depend on the grid.
"""

from typing import Final, NamedTuple

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import IntArray
from slam.pose import FloatArray

SIDES: Final = 16
"""Number of directions into which the normals are sorted before facets are grouped."""
CELL: Final = 0.3
"""Length of a piece along a wall, metres."""
TABLE: Final = 512
"""Rows and columns of the table of pieces; cells this many apart share an entry."""
NEIGHBOURS = 2  # cells to each side in which a wall may continue
WALL_COSINE = 0.95  # least cosine between the normals of a piece and of its wall
SIGMAS = 0.5  # standard deviations of a piece's position that are added to the largest deviation from a straight wall
LEVER = 0.3  # metres: a normal counts as two points this far apart
MIN_SCANS = 2  # least number of scans that see a wall
W, WX, WY, WXX, WXY, WYY, WNX, WNY, WNXX, WNXY, WNYY = range(11)
"""Weighted sums from which a line is fitted: of 1, x, y, xx, xy, yy, and of the normals: x, y, xx, xy, yy."""
LINE_NX, LINE_NY, LINE_X, LINE_Y = range(4)
"""Columns of lines (M, 4): unit normal away from the sensor, and a point in the middle of the seen part."""


class PlacedFacets(NamedTuple):
    """Facets of all key scans in one frame, in the order of the scans."""

    points: FloatArray
    """(F, 2): centres."""
    normals: FloatArray
    """(F, 2): normals, away from the sensor."""
    levers: FloatArray
    """(F, 2): from the sensor to the centre."""
    variances: FloatArray
    """(F,): variance of the centre along the normal, m^2."""
    scans: IntArray
    """(F,): index of the key scan."""


class FoundWalls(NamedTuple):
    """Walls, and the facets that see them."""

    lines: FloatArray
    """(M, 4)."""
    facets: IntArray
    """(G,): indices of facets, sorted by wall and within a wall by scan."""
    begins: IntArray
    """(M + 1,): first facet of each wall, and G."""


def find_walls(placed: PlacedFacets, straight: float, gap: float) -> FoundWalls:
    """Find the walls that at least two scans see.

    Neighbouring facets of a piece are no farther apart across it than ``gap``, metres, and a piece lies no farther off
    the line of its wall than ``straight``, metres.
    """
    information = 1.0 / placed.variances
    cell, key = _sort_keys(placed.points, placed.normals)
    order = np.argsort(key, kind="stable")
    piece_of, pieces = _pieces(placed.points, placed.normals, information, cell, order, gap)
    columns_rows = np.floor(pieces[:, WX : WY + 1] / (CELL * pieces[:, W : W + 1])).astype(np.int64)
    heaviest_first = np.argsort(-pieces[:, W], kind="stable")
    wall_of_piece, lines = _grow_walls(pieces, columns_rows, heaviest_first, straight)
    return FoundWalls(*_sort_by_wall(wall_of_piece[piece_of], placed.scans, lines))


@compiled
def wall_spans(points: FloatArray, lines: FloatArray, numbers: IntArray, begins: IntArray) -> FloatArray:
    """Return begin and end of each wall along its line (M, 4), (M, 2), metres from the point of the line.

    The other arguments are those of PlacedFacets and FoundWalls.
    """
    spans = np.empty((len(lines), 2))
    for m in range(len(lines)):
        nx, ny, x, y = lines[m, LINE_NX], lines[m, LINE_NY], lines[m, LINE_X], lines[m, LINE_Y]
        low, high = np.inf, -np.inf
        for f in numbers[begins[m] : begins[m + 1]]:
            along = nx * (points[f, 1] - y) - ny * (points[f, 0] - x)
            low, high = min(low, along), max(high, along)
        spans[m, 0], spans[m, 1] = low, high
    return spans


@compiled
def _sort_keys(points: FloatArray, normals: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the cell of each facet, and a key that sorts the facets of a cell; (F,) each.

    The cell depends on the direction that the facet faces and on its position along the wall; the key sorts by the
    position across the wall.
    """
    cell, key = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
    for f in range(len(points)):
        turn = np.arctan2(normals[f, 1], normals[f, 0]) * SIDES / (2.0 * np.pi)
        side = int(np.floor(turn + 0.5)) % SIDES
        c, s = np.cos(side * 2.0 * np.pi / SIDES), np.sin(side * 2.0 * np.pi / SIDES)
        along, across = c * points[f, 1] - s * points[f, 0], c * points[f, 0] + s * points[f, 1]
        cell[f] = (side << 24) + (1 << 23) + int(np.floor(along / CELL))
        key[f] = (cell[f] << 32) + (1 << 31) + int(np.floor(1e4 * across))
    return cell, key


@compiled
def _pieces(
    points: FloatArray, normals: FloatArray, information: FloatArray, cell: IntArray, order: IntArray, gap: float
) -> tuple[IntArray, FloatArray]:
    """Return the piece of each facet (F,), and the sums of each piece (P, 11)."""
    piece_of, sums, count = np.empty(len(points), np.int64), np.zeros((len(points), 11)), 0
    for i in range(len(order)):
        f, before = order[i], order[i - 1]
        x, y, nx, ny = points[f, 0], points[f, 1], normals[f, 0], normals[f, 1]
        apart = abs((x - points[before, 0]) * nx + (y - points[before, 1]) * ny)
        if i == 0 or cell[f] != cell[before] or apart > gap:
            count += 1
        piece_of[f] = count - 1
        products = (1.0, x, y, x * x, x * y, y * y, nx, ny, nx * nx, nx * ny, ny * ny)
        for j in range(11):
            sums[count - 1, j] += information[f] * products[j]
    return piece_of, sums[:count]


@compiled_on_views
def _fit(sums: FloatArray, seed: FloatArray, line: FloatArray) -> None:
    """Fit a line (4,) to sums (11,), by the scatter of points and normals; it faces the same side as the seed's."""
    w, x, y = sums[W], sums[WX] / sums[W], sums[WY] / sums[W]
    xx = sums[WXX] - w * x * x - LEVER * LEVER * sums[WNXX]
    xy = sums[WXY] - w * x * y - LEVER * LEVER * sums[WNXY]
    yy = sums[WYY] - w * y * y - LEVER * LEVER * sums[WNYY]
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    nx, ny = -np.sin(along), np.cos(along)
    sign = 1.0 if nx * seed[WNX] + ny * seed[WNY] >= 0.0 else -1.0
    line[LINE_NX], line[LINE_NY], line[LINE_X], line[LINE_Y] = sign * nx, sign * ny, x, y


@compiled
def _grow_walls(
    pieces: FloatArray, columns_rows: IntArray, heaviest_first: IntArray, straight: float
) -> tuple[IntArray, FloatArray]:
    """Return the wall of each piece (P,), and the lines (M, 4)."""
    head = np.full((TABLE, TABLE), -1, np.int64)  # hash table: first piece of all cells with this remainder
    following, wall_of = np.empty(len(pieces), np.int64), np.full(len(pieces), -1, np.int64)
    for k in range(len(pieces)):
        column, row = columns_rows[k, 0] % TABLE, columns_rows[k, 1] % TABLE
        following[k] = head[row, column]
        head[row, column] = k
    lines, queue, count = np.empty((len(pieces), 4)), np.empty(len(pieces), np.int64), 0
    for seed in heaviest_first:
        if wall_of[seed] < 0:
            _grow_one(pieces, columns_rows, head, following, straight, wall_of, queue, seed, count, lines[count])
            count += 1
    return wall_of, lines[:count]


@compiled
def _grow_one(
    pieces: FloatArray, columns_rows: IntArray, head: IntArray, following: IntArray, straight: float,
    wall_of: IntArray, queue: IntArray, seed: int, number: int, line: FloatArray,
) -> None:  # fmt: skip
    """Grow one wall from its heaviest piece over its neighbours; ``queue`` (P,) is scratch, ``line`` is written."""
    sums = pieces[seed].copy()
    _fit(sums, pieces[seed], line)
    wall_of[seed], queue[0] = number, seed
    begin, end = 0, 1
    while begin < end:
        column, row = columns_rows[queue[begin], 0], columns_rows[queue[begin], 1]
        begin += 1
        for i in range(row - NEIGHBOURS, row + NEIGHBOURS + 1):
            for j in range(column - NEIGHBOURS, column + NEIGHBOURS + 1):
                k = head[i % TABLE, j % TABLE]
                while k >= 0:
                    here = columns_rows[k, 0] == j and columns_rows[k, 1] == i
                    if here and wall_of[k] < 0 and _lies_on(pieces[k], line, straight):
                        wall_of[k], queue[end] = number, k
                        end += 1
                        sums += pieces[k]
                        _fit(sums, pieces[seed], line)
                    k = following[k]
    _drop_deviating(pieces, queue[1:end], straight, wall_of, sums, line)
    _fit(sums, pieces[seed], line)


@compiled
def _drop_deviating(
    pieces: FloatArray, members: IntArray, straight: float, wall_of: IntArray, sums: FloatArray, line: FloatArray
) -> None:
    """Remove pieces from which the line of the wall turned away while it grew; they may form another wall."""
    for k in members:
        if not _lies_on(pieces[k], line, straight):
            wall_of[k] = -1
            sums -= pieces[k]


@compiled_on_views
def _lies_on(piece: FloatArray, line: FloatArray, straight: float) -> bool:
    """Return True if a piece faces the same side as a line, and is within ``straight`` metres plus its uncertainty."""
    nx, ny, w = line[LINE_NX], line[LINE_NY], piece[W]
    offset = nx * (piece[WX] / w - line[LINE_X]) + ny * (piece[WY] / w - line[LINE_Y])
    cosine, sine = (nx * piece[WNX] + ny * piece[WNY]) / w, (nx * piece[WNY] - ny * piece[WNX]) / w
    variance = SIGMAS * SIGMAS / w
    is_on = offset * offset < straight * straight + variance
    is_along = (sine * LEVER) ** 2 < (0.5 * straight) ** 2 + 2.0 * variance
    return bool(cosine > WALL_COSINE and is_on and is_along)


@compiled
def _sort_by_wall(wall_of: IntArray, scans: IntArray, lines: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Return FoundWalls of the walls that MIN_SCANS scans see; ``wall_of`` and ``scans`` are of facets (F,)."""
    counts, seen = np.zeros(len(lines), np.int64), np.zeros(len(lines), np.int64)
    last = np.full(len(lines), -1, np.int64)
    for f in range(len(wall_of)):
        m = wall_of[f]
        counts[m] += 1
        if last[m] != scans[f]:
            seen[m], last[m] = seen[m] + 1, scans[f]
    kept, begins, count = np.empty((len(lines), 4)), np.zeros(len(lines) + 1, np.int64), 0
    at = np.full(len(lines), -1, np.int64)
    for m in range(len(lines)):
        if seen[m] >= MIN_SCANS:
            for i in range(4):
                kept[count, i] = lines[m, i]
            at[m] = begins[count]
            begins[count + 1] = begins[count] + counts[m]
            count += 1
    facets = np.empty(begins[count], np.int64)
    for f in range(len(wall_of)):
        m = wall_of[f]
        if at[m] >= 0:
            facets[at[m]] = f
            at[m] += 1
    return kept[:count], facets, begins[: count + 1]
