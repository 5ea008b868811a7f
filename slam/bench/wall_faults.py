"""Faults of a line map that are visible without ground truth: walls along their own beams, duplicates, unseen walls.

Lines are (M, 2, 2), [line, start or end, x or y], each with the lidar's side to its left; metres.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from slam.lines.segments import IntArray
from slam.pose import FloatArray

PIECE: Final = 0.05
"""Longest piece of a line that is checked, metres."""
ON_LINE: Final = 0.10
"""Largest distance of an echo from the line that it belongs to, metres."""
GRAZING: Final = float(np.cos(np.radians(5.0)))
"""Least cosine between a line and a beam along it."""
RADIAL: Final = 0.3
"""Least length of a radial line, metres: the direction of a shorter one is uncertain."""
BESIDE: Final = 0.30
"""Largest distance of two lines that show one wall, metres."""
SAME_WAY: Final = float(np.cos(np.radians(10.0)))
"""Least cosine between two lines that show one wall."""


class WallFaults(NamedTuple):
    """Metres of a line map that look wrong."""

    length: float
    """Length of all lines, metres."""
    radial: float
    """Metres of lines most of whose echoes came from beams along them: fans where beams graze clutter."""
    parallel: float
    """Metres of pieces beside a longer line that faces the same way: walls drawn twice, and bands of strokes."""
    unseen: float
    """Metres of pieces without an echo."""
    lines: int
    """Number of lines."""

    @property
    def lines_per_metre(self) -> float:
        """Pieces per metre of wall."""
        return self.lines / self.length if self.length > 0.0 else 0.0


def wall_faults(lines: FloatArray, points: FloatArray, origins: FloatArray) -> WallFaults:
    """Measure the lines against the echoes at ``points`` (K, 2) of beams from ``origins`` (K, 2)."""
    lengths = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    of_piece, middles = _pieces(lines)
    piece_lengths = lengths[of_piece] / np.bincount(of_piece, minlength=len(lines))[of_piece]
    unseen = _distances(middles, points) > ON_LINE
    return WallFaults(
        float(lengths.sum()),
        float(lengths[radial_lines(lines, points, origins)].sum()),
        float(piece_lengths[_beside_longer(lines, of_piece, middles)].sum()),
        float(piece_lengths[unseen].sum()),
        len(lines),
    )


def radial_lines(lines: FloatArray, points: FloatArray, origins: FloatArray) -> NDArray[np.bool_]:
    """Return True for the lines, RADIAL or longer, most of whose echoes came from beams along them, (M,)."""
    if not len(lines) or not len(points):
        return np.zeros(len(lines), np.bool_)
    of_piece, middles = _pieces(lines)
    distance, nearest = cKDTree(middles).query(points, distance_upper_bound=ON_LINE + PIECE / 2)
    hit = np.isfinite(distance)
    line = of_piece[nearest[hit]]
    beams, directions = points[hit] - origins[hit], (lines[:, 1] - lines[:, 0])[line]
    along = np.abs(np.sum(beams * directions, axis=1)) >= GRAZING * np.hypot(*beams.T) * np.hypot(*directions.T)
    echoes, radial = np.bincount(line, minlength=len(lines)), np.bincount(line[along], minlength=len(lines))
    long_enough = np.hypot(*(lines[:, 1] - lines[:, 0]).T) >= RADIAL
    return np.asarray((2 * radial > echoes) & long_enough)


def _beside_longer(lines: FloatArray, of_piece: IntArray, middles: FloatArray) -> NDArray[np.bool_]:
    """Return True for the pieces beside a line that is longer than theirs, or equally long and before it, (P,)."""
    directions = lines[:, 1] - lines[:, 0]
    lengths = np.hypot(*directions.T)
    directions = directions / np.maximum(lengths, 1e-12)[:, None]
    rank = np.argsort(np.argsort(-lengths, kind="stable"))
    beside = np.zeros(len(middles), np.bool_)
    for m, (start, direction) in enumerate(zip(lines[:, 0], directions, strict=True)):
        to_piece = middles - start
        along, across = to_piece @ direction, to_piece @ np.array([-direction[1], direction[0]])
        same = (directions @ direction >= SAME_WAY) & (rank > rank[m])
        beside |= same[of_piece] & (along > 0.0) & (along < lengths[m]) & (np.abs(across) <= BESIDE)
    return beside


def _pieces(lines: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the line of every piece, (P,), and the middle of the piece, (P, 2)."""
    counts = np.ceil(np.hypot(*(lines[:, 1] - lines[:, 0]).T) / PIECE).astype(np.int64)
    line = np.repeat(np.arange(len(lines)), counts)
    place = np.arange(len(line)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((place + 0.5) / counts[line])[:, None]
    return line, (1.0 - share) * lines[line, 0] + share * lines[line, 1]


def _distances(places: FloatArray, points: FloatArray) -> FloatArray:
    """Return the distance of every position from the nearest point; infinite without one."""
    return np.asarray(cKDTree(points).query(places)[0] if len(points) else np.full(len(places), np.inf))
