"""The true walls of a world as the lidar could see them: the free faces of its solids, cut at the lidar's height."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.lines.segments import IntArray
from slam.pose import FloatArray

SPACING: Final = 0.05
"""Metres between the samples of a face, at most."""
ASIDE: Final = 1e-3
"""Metres before a face where nothing may stand, for it to be free; faces on one line no farther apart are one."""
ROUNDING: Final = 1e-6
"""Metres: a part that is shorter has no direction."""
BRIDGED: Final = 0.2
"""Metres: faces on one line no farther apart are one wall, against which something stands, such as a thin wall."""
SHORTEST: Final = 5e-3
"""Metres: what is left of a face between two solids and is shorter is none."""


class TrueWalls(NamedTuple):
    """F faces and N samples of them; metres, map frame."""

    faces: FloatArray
    """(F, 2, 2): [face, start or end, x or y]. The free side is to the left, as the lidar is of a mapped segment."""
    is_end: NDArray[np.bool_]
    """True where a wall ends with its face, and does not go on behind what stands against it, (F, 2)."""
    samples: FloatArray
    """(N, 2): middles of equal parts of each face, in its order ..."""
    face_of: IntArray
    """... the face of each (N,), which rises ..."""
    weights: FloatArray
    """... and the length that it stands for, (N,)."""

    @property
    def lengths(self) -> FloatArray:
        """Length of every face, (F,)."""
        return np.asarray(np.hypot(*(self.faces[:, 1] - self.faces[:, 0]).T))


def true_walls(outlines: Sequence[FloatArray]) -> TrueWalls:
    """The free faces of solids with these outlines (K, 2), each convex and counter-clockwise.

    What stands against another solid or within it is no face. Faces that touch on one line are one: a wall may be made
    of many solids.
    """
    if not outlines:
        return _sampled(np.empty((0, 2, 2)))
    return _sampled(_joined(_free_parts(outlines)))


def _free_parts(outlines: Sequence[FloatArray]) -> FloatArray:
    """The parts of all edges before which nothing stands, each with its free side to the left, (F, 2, 2)."""
    low, high = (np.array([bound(outline, axis=0) for outline in outlines]) for bound in (np.min, np.max))
    parts = [np.empty((0, 2, 2))]
    for outline in outlines:
        for start, end in zip(np.roll(outline, -1, axis=0), outline, strict=True):
            way = end - start
            length = max(float(np.hypot(*way)), ROUNDING)
            before = start + np.array([-way[1], way[0]]) * (ASIDE / length)
            corners = np.array([before, before + way])
            near = np.all((corners.max(axis=0) >= low) & (corners.min(axis=0) <= high), axis=1)
            hidden = [_part_within(before, way, outlines[k]) for k in np.flatnonzero(near).tolist()]
            free = np.array([part for part in _left_free(hidden) if (part[1] - part[0]) * length > ROUNDING])
            parts.append(start + free.reshape(-1, 2, 1) * way)
    return np.concatenate(parts)


def _part_within(start: FloatArray, way: FloatArray, outline: FloatArray) -> tuple[float, float]:
    """Shares of the way from the start between which it is in the convex solid; begin >= end for never."""
    edges = np.roll(outline, -1, axis=0) - outline
    to_start = start - outline
    here = edges[:, 0] * to_start[:, 1] - edges[:, 1] * to_start[:, 0]  # positive to the left of the edge: inside
    change = edges[:, 0] * way[1] - edges[:, 1] * way[0]
    level = np.abs(change) < 1e-12
    if np.any(here[level] < 0.0):
        return 1.0, 0.0
    shares = -here[~level] / change[~level]
    enters = change[~level] > 0.0
    return float(shares[enters].max(initial=0.0)), float(shares[~enters].min(initial=1.0))


def _left_free(hidden: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """Yield what these parts leave of the whole, from 0 to 1."""
    at = 0.0
    for begin, end in sorted(part for part in hidden if part[0] < part[1]):
        if begin > at:
            yield at, begin
        at = max(at, end)
    if at < 1.0:
        yield at, 1.0


class _Placed(NamedTuple):
    """Lines (M, 2, 2) on the line that each lies on."""

    line: IntArray
    """Number of that line and of its side, (M,)."""
    begin: FloatArray
    """Place of the start along it, metres, (M,) ..."""
    end: FloatArray
    """... and of the end."""
    order: IntArray
    """Line by line, each from its first start to its last."""


def _placed(lines: FloatArray) -> _Placed:
    way = lines[:, 1] - lines[:, 0]
    along = way / np.hypot(*way.T)[:, None]
    rho = along[:, 0] * lines[:, 0, 1] - along[:, 1] * lines[:, 0, 0]
    begin, end = (np.sum(along * lines[:, side], axis=1) for side in (0, 1))
    line = np.unique(np.round(np.column_stack([along, rho]), 6) + 0.0, axis=0, return_inverse=True)[1].ravel()
    return _Placed(line, begin, end, np.lexsort([begin, line]))


def _joined(parts: FloatArray) -> FloatArray:
    """Parts that touch or overlap on one line, facing the same way, as one face each."""
    line, begin, end, order = _placed(parts)
    faces: list[FloatArray] = []
    at, reach = -1, -np.inf
    for k in order:
        if line[k] != at or begin[k] > reach + ASIDE:
            faces.append(parts[k].copy())
            at, reach = line[k], end[k]
        elif end[k] > reach:
            faces[-1][1], reach = parts[k, 1], end[k]
    joined = np.array(faces).reshape(-1, 2, 2)
    lengths: FloatArray = np.hypot(*(joined[:, 1] - joined[:, 0]).T)
    return np.asarray(joined[lengths >= SHORTEST])


def _is_end(faces: FloatArray) -> NDArray[np.bool_]:
    """True for the starts and ends of faces (F, 2) behind which the wall does not go on."""
    line, begin, end, order = _placed(faces)
    first, second = order[:-1], order[1:]
    goes_on = (line[first] == line[second]) & (begin[second] - end[first] <= BRIDGED)
    are = np.ones((len(faces), 2), np.bool_)
    are[first[goes_on], 1] = are[second[goes_on], 0] = False
    return are


def _sampled(faces: FloatArray) -> TrueWalls:
    lengths = np.hypot(*(faces[:, 1] - faces[:, 0]).T)
    counts = np.ceil(lengths / SPACING - 1e-9).astype(np.int64)
    face_of = np.repeat(np.arange(len(faces)), counts)
    place = np.arange(len(face_of)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((place + 0.5) / counts[face_of])[:, None]
    samples = (1.0 - share) * faces[face_of, 0] + share * faces[face_of, 1]
    return TrueWalls(faces, _is_end(faces), samples, face_of, (lengths / np.maximum(counts, 1))[face_of])
