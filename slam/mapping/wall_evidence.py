"""Evidence of beams for each piece of a surfel: that there is wall, or that there is none; compiled.

A surfel is a line through its cell. Only the beams can show how much of it is wall, so each surfel has a count for
every piece of its line: an echo increases it, a beam that went through decreases it. Pieces are cut by a grid of the
map, and not by the surfel, whose centre moves. They reach half a cell beyond the surfel's own cell, as not every cell
that a wall crosses has a surfel. The counts are bounded, so that a removed wall can be forgotten.
"""

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.lines.segments import IntArray
from slam.mapping.free_beams import FreeBeams, beam_towards, is_hidden
from slam.mapping.free_space import cells_around
from slam.mapping.surfel_grid import AXIS, HITS, NX, NY, PIECES, PIECES_PER_CELL, Grid, X, Y
from slam.pose import FloatArray
from slam.scan import COS, SIN

MOST, LEAST = 30, -10  # limits of a count, to both sides
GRAZING = 0.2  # least cosine of incidence of an echo that is evidence of a wall
NEAREST = 0.1  # metres: nothing nearer to the sensor is counted
SAME_SIDE = 0.3  # least cosine between two surfels of one wall; otherwise they may form a corner
CLEARLY_FARTHER = 0.05  # metres: more than the difference of two surfels of one wall
MAX_BESIDE = 8  # largest number of surfels that an echo could come from
CLEARLY_BEYOND = 0.10  # metres along the beam, and share of the range, beyond a wall: the beam went through
BEYOND_SHARE = 0.02


def evidence_of_hits(surfels: FloatArray) -> NDArray[np.int8]:
    """Return the evidence (S, 9) of surfels (S, 8) of a map that has none: the hits count as echoes in the own cell."""
    evidence = np.zeros((len(surfels), PIECES + 1), np.int8)
    own = slice(PIECES_PER_CELL // 2, PIECES_PER_CELL // 2 + PIECES_PER_CELL)
    evidence[:, own] = np.minimum(surfels[:, HITS], MOST)[:, None]
    evidence[:, AXIS] = np.abs(surfels[:, NX]) > np.abs(surfels[:, NY])
    return evidence


@compiled
def weigh_walls(grid: Grid, beams: FreeBeams, pose: FloatArray, reach: float, gate: float) -> None:
    """Count echoes and passes of the beams from ``pose`` (3,) on the pieces of the surfels within ``reach``.

    An echo no farther than ``gate`` metres from a surfel's line, across it, comes from there.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    directions = np.empty((len(beams.ranges), 2))
    for j in range(len(directions)):
        directions[j, 0] = c * beams.fan[COS, j] - s * beams.fan[SIN, j]
        directions[j, 1] = s * beams.fan[COS, j] + c * beams.fan[SIN, j]
    _count_echoes(grid, beams, directions, pose, gate)
    surfels, farthest = grid.surfels, beams.farthest
    x, y = pose[0], pose[1]
    low_row, high_row, low_column, high_column = cells_around(grid, pose, reach)
    for row in range(low_row, high_row):
        for column in range(low_column, high_column):
            k = grid.head[row, column]
            while k >= 0:
                dx, dy = surfels[k, X] - x, surfels[k, Y] - y
                distance = np.sqrt(dx * dx + dy * dy)
                offset = abs(dx * surfels[k, NX] + dy * surfels[k, NY])
                edge_on = offset < GRAZING * distance  # a surfel without a normal is ignored too
                if not edge_on and not is_hidden(farthest, c * dx + s * dy, c * dy - s * dx, distance - grid.cell):
                    _count_passes(grid, k, beams, directions, pose, reach, gate)
                k = grid.next[k]


@compiled
def _count_echoes(grid: Grid, beams: FreeBeams, directions: FloatArray, pose: FloatArray, gate: float) -> None:
    """Increase the count of the piece that each echo comes from: of the nearest surfel whose line has a piece there.

    Counts of other possible surfels that are clearly farther decrease.

    Of many echoes within half a piece the first stands for all.
    """
    last_x = last_y = np.inf
    last_surfel, last_piece = -1, -1
    beside, offsets = np.empty((MAX_BESIDE, 2), np.int64), np.empty(MAX_BESIDE)
    apart = 0.5 * grid.cell / PIECES_PER_CELL
    for j in range(len(directions)):
        x, y = pose[0] + beams.ranges[j] * directions[j, 0], pose[1] + beams.ranges[j] * directions[j, 1]
        if not beams.echoes[j] or abs(x - last_x) + abs(y - last_y) < apart:
            continue
        last_x, last_y = x, y
        count = _surfels_beside(grid, x, y, directions[j, 0], directions[j, 1], gate, beside, offsets)
        surfel, piece = -1, -1
        if count > 0:
            nearest = _least(offsets, count)
            surfel, piece = beside[nearest, 0], beside[nearest, 1]
            if surfel != last_surfel or piece != last_piece:
                _count_one(grid, beside, offsets, count, nearest)
        last_surfel, last_piece = surfel, piece


@compiled_on_views
def _surfels_beside(
    grid: Grid, x: float, y: float, way_x: float, way_y: float, gate: float, beside: IntArray, offsets: FloatArray
) -> int:
    """List the surfels, each with its piece (MAX_BESIDE, 2), from which an echo at (x, y) of a beam could come.

    It also writes the distance of the echo from the line of each surfel, and returns the number of surfels.

    Pieces extend half a cell beyond the surfel's cell, so that it is in one of the four nearest cells.
    """
    surfels, (rows, columns) = grid.surfels, grid.head.shape
    row = int(np.floor(y / grid.cell - 0.5)) - grid.corner[0]
    column = int(np.floor(x / grid.cell - 0.5)) - grid.corner[1]
    count = 0
    for i in range(max(row, 0), min(row + 2, rows)):
        for h in range(max(column, 0), min(column + 2, columns)):
            k = grid.head[i, h]
            while k >= 0:
                nx, ny = surfels[k, NX], surfels[k, NY]
                across = abs((x - surfels[k, X]) * nx + (y - surfels[k, Y]) * ny)
                if across < gate and way_x * nx + way_y * ny > GRAZING and count < MAX_BESIDE:
                    piece = piece_at(grid, k, x, y)
                    if piece >= 0:
                        beside[count, 0], beside[count, 1], offsets[count] = k, piece, across
                        count += 1
                k = grid.next[k]
    return count


@compiled_on_views
def _least(offsets: FloatArray, count: int) -> int:
    """Return the index of the least of the first ``count`` offsets."""
    least = 0
    for i in range(1, count):
        if offsets[i] < offsets[least]:
            least = i
    return least


@compiled_on_views
def _count_one(grid: Grid, beside: IntArray, offsets: FloatArray, count: int, nearest: int) -> None:
    """Increase the count of the nearest of ``count`` surfels for an echo, and decrease clearly farther ones.

    Only surfels of the same side decrease.
    """
    surfel, piece = beside[nearest, 0], beside[nearest, 1]
    grid.evidence[surfel, piece] = min(grid.evidence[surfel, piece] + 1, MOST)
    nx, ny = grid.surfels[surfel, NX], grid.surfels[surfel, NY]
    for i in range(count):
        k, other = beside[i, 0], beside[i, 1]
        same_side = nx * grid.surfels[k, NX] + ny * grid.surfels[k, NY] > SAME_SIDE
        if same_side and offsets[i] > offsets[nearest] + CLEARLY_FARTHER:
            grid.evidence[k, other] = max(grid.evidence[k, other] - 1, LEAST)


@compiled_on_views
def _count_passes(
    grid: Grid, k: int, beams: FreeBeams, directions: FloatArray, pose: FloatArray, reach: float, gate: float
) -> None:
    """Decrease the counts of a surfel's pieces that beams went through; a surfel with a hidden middle is ignored."""
    nx, ny = grid.surfels[k, NX], grid.surfels[k, NY]
    dx, dy = grid.surfels[k, X] - pose[0], grid.surfels[k, Y] - pose[1]
    distance = np.sqrt(dx * dx + dy * dy)
    offset = dx * nx + dy * ny
    if not NEAREST < distance < reach:
        return
    middle = beam_towards(beams, pose, dx, dy)
    if not 0 <= middle < len(directions) or beams.ranges[middle] < distance - grid.cell:
        return
    half = int(np.arctan(grid.cell * abs(offset) / (distance * distance)) / beams.angle_increment) + 2
    before = -1
    for j in range(max(middle - half, 0), min(middle + half + 1, len(directions))):
        cosine = directions[j, 0] * nx + directions[j, 1] * ny
        if cosine * offset <= 0.0 or abs(cosine) < GRAZING:
            continue
        r = offset / cosine
        beyond = beams.ranges[j] - r
        if beyond * abs(cosine) > gate and beyond > CLEARLY_BEYOND + BEYOND_SHARE * r:
            piece = piece_at(grid, k, pose[0] + r * directions[j, 0], pose[1] + r * directions[j, 1])
            if piece >= 0 and piece != before:
                grid.evidence[k, piece] = max(grid.evidence[k, piece] - 1, LEAST)
            before = piece


@compiled_on_views
def piece_at(grid: Grid, k: int, x: float, y: float) -> int:
    """Return the piece of the surfel ``k`` beside a point, -1 for none."""
    along_y = grid.evidence[k, AXIS] > 0
    centre, at = (grid.surfels[k, Y], y) if along_y else (grid.surfels[k, X], x)
    width = grid.cell / PIECES_PER_CELL
    begin = (np.floor(centre / grid.cell) - 0.5) * grid.cell
    piece = int(np.floor((at - begin) / width))
    return piece if 0 <= piece < PIECES else -1
