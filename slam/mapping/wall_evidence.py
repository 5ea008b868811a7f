"""What beams tell of each piece of a surfel, compiled: that there is wall, or that there is none.

A surfel is a line through its cell. Whether there is wall all along it only the beams can tell, so that each surfel
keeps a count for every piece of its line: up for an echo from there, down for a beam that went through. Pieces are cut
by a grid of the map, and not by the surfel, whose centre moves. They reach half a cell beyond the surfel's own cell, as
not every cell that a wall crosses has a surfel. The counts are bounded, so that a wall that has gone can be forgotten.
"""

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.mapping.free_space import FreeBeams, beam_towards, cells_around
from slam.mapping.surfel_grid import AXIS, HITS, NX, NY, PIECES, PIECES_A_CELL, Grid, X, Y
from slam.pose import FloatArray
from slam.scan import COS, SIN

MOST, LEAST = 30, -10  # a count is no greater and no less
GRAZING = 0.2  # cosine of incidence, below which an echo does not tell where a wall is
NEAREST = 0.1  # metres: nothing nearer to the sensor is judged
CLEARLY_BEYOND = 0.10  # metres along the beam, and this share of the range, beyond a wall: the beam went through
BEYOND_SHARE = 0.02


def evidence_of_hits(surfels: FloatArray) -> NDArray[np.int8]:
    """The evidence (S, 9) of surfels (S, 7) of which none was kept: each is wall in its own cell."""
    evidence = np.zeros((len(surfels), PIECES + 1), np.int8)
    own = slice(PIECES_A_CELL // 2, PIECES_A_CELL // 2 + PIECES_A_CELL)
    evidence[:, own] = np.minimum(surfels[:, HITS], MOST)[:, None]
    evidence[:, AXIS] = np.abs(surfels[:, NX]) > np.abs(surfels[:, NY])
    return evidence


@compiled
def weigh_walls(
    grid: Grid, beams: FreeBeams, echoes: NDArray[np.bool_], pose: FloatArray, reach: float, gate: float
) -> None:
    """Count echoes and passes of the beams from ``pose`` (3,) on the pieces of the surfels within ``reach``.

    An echo no farther than ``gate`` metres from a surfel's line, across it, comes from there.
    """
    _count_echoes(grid, beams, echoes, pose, gate)
    low_row, high_row, low_column, high_column = cells_around(grid, pose, reach)
    for row in range(low_row, high_row):
        for column in range(low_column, high_column):
            k = grid.head[row, column]
            while k >= 0:
                if grid.surfels[k, NX] != 0.0 or grid.surfels[k, NY] != 0.0:
                    _count_passes(grid, k, beams, pose, reach, gate)
                k = grid.next[k]


@compiled
def _count_echoes(grid: Grid, beams: FreeBeams, echoes: NDArray[np.bool_], pose: FloatArray, gate: float) -> None:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    rows, columns = grid.head.shape
    last_surfel, last_piece = -1, -1
    for j in range(len(beams.ranges)):
        if not echoes[j]:
            continue
        ux = c * beams.fan[COS, j] - s * beams.fan[SIN, j]
        uy = s * beams.fan[COS, j] + c * beams.fan[SIN, j]
        x, y = pose[0] + beams.ranges[j] * ux, pose[1] + beams.ranges[j] * uy
        row, column = int(np.floor(y / grid.cell)) - grid.corner[0], int(np.floor(x / grid.cell)) - grid.corner[1]
        best, best_piece, nearest = -1, -1, gate
        for i in range(max(row - 1, 0), min(row + 2, rows)):
            for h in range(max(column - 1, 0), min(column + 2, columns)):
                k = grid.head[i, h]
                while k >= 0:
                    f = grid.surfels[k]
                    across = abs((x - f[X]) * f[NX] + (y - f[Y]) * f[NY])
                    if across < nearest and ux * f[NX] + uy * f[NY] > GRAZING:
                        piece = piece_at(grid, k, x, y)
                        if piece >= 0:
                            best, best_piece, nearest = k, piece, across
                    k = grid.next[k]
        if best >= 0 and not (best == last_surfel and best_piece == last_piece):
            grid.evidence[best, best_piece] = min(grid.evidence[best, best_piece] + 1, MOST)
        last_surfel, last_piece = best, best_piece


@compiled
def _count_passes(grid: Grid, k: int, beams: FreeBeams, pose: FloatArray, reach: float, gate: float) -> None:
    """Count down the pieces of a surfel that beams went through."""
    f = grid.surfels[k]
    dx, dy = f[X] - pose[0], f[Y] - pose[1]
    distance = np.sqrt(dx * dx + dy * dy)
    offset = dx * f[NX] + dy * f[NY]
    if not NEAREST < distance < reach or abs(offset) < GRAZING * distance:
        return
    half = grid.cell * np.sqrt(2.0)
    if distance < half:
        half = 0.9 * distance
    first = beam_towards(beams, pose, dx - half * f[NY], dy + half * f[NX])
    last = beam_towards(beams, pose, dx + half * f[NY], dy - half * f[NX])
    if first > last:
        first, last = last, first
    if last - first > len(beams.ranges) // 2:  # seen across the ends of the fan
        return
    c, s = np.cos(pose[2]), np.sin(pose[2])
    before = -1
    for j in range(max(first, 0), min(last + 1, len(beams.ranges))):
        ux = c * beams.fan[COS, j] - s * beams.fan[SIN, j]
        uy = s * beams.fan[COS, j] + c * beams.fan[SIN, j]
        cosine = ux * f[NX] + uy * f[NY]
        if cosine * offset <= 0.0 or abs(cosine) < GRAZING:
            continue
        r = offset / cosine
        beyond = beams.ranges[j] - r
        if beyond * abs(cosine) > gate and beyond > CLEARLY_BEYOND + BEYOND_SHARE * r:
            piece = piece_at(grid, k, pose[0] + r * ux, pose[1] + r * uy)
            if piece >= 0 and piece != before:
                grid.evidence[k, piece] = max(grid.evidence[k, piece] - 1, LEAST)
            before = piece


@compiled
def piece_at(grid: Grid, k: int, x: float, y: float) -> int:
    """The piece of the surfel ``k`` beside a point, -1 for none."""
    along_y = grid.evidence[k, AXIS] > 0
    centre, at = (grid.surfels[k, Y], y) if along_y else (grid.surfels[k, X], x)
    width = grid.cell / PIECES_A_CELL
    begin = (np.floor(centre / grid.cell) - 0.5) * grid.cell
    piece = int(np.floor((at - begin) / width))
    return piece if 0 <= piece < PIECES else -1
