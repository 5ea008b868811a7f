"""The true walls of a world that the lidar could see: the free faces of its solids, cut at the lidar's height."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from slam.lines.segments import IntArray
from slam.pose import FloatArray

SPACING: Final = 0.05
"""Largest distance between the samples of a face, metres."""
ASIDE: Final = 1e-3
"""Depth in front of a face that must be free, metres; faces on one line with a smaller gap are joined."""
ROUNDING: Final = 1e-6
"""Least length of a part that has a direction, metres."""
BLOCK: Final = 256
"""Number of edges, sorted by x, that are compared at once with all solids at the same x."""
SHORTEST: Final = 5e-3
"""Least length of a part of a face between two solids, metres."""


class TrueWalls(NamedTuple):
    """F faces and N samples of them; metres, map frame."""

    faces: FloatArray
    """(F, 2, 2): [face, start or end, x or y]. The free side is to the left, like the lidar of a mapped segment."""
    samples: FloatArray
    """(N, 2): middles of equal parts of each face, in its order."""
    face_of: IntArray
    """(N,): face of each sample, in ascending order."""
    weights: FloatArray
    """(N,): length of the part of each sample."""

    @property
    def lengths(self) -> FloatArray:
        """Length of every face, (F,)."""
        return np.asarray(np.hypot(*(self.faces[:, 1] - self.faces[:, 0]).T))


def true_walls(outlines: Sequence[FloatArray]) -> TrueWalls:
    """Return the free faces of solids with these outlines (K, 2), each convex and counter-clockwise.

    Parts that touch another solid or lie within it are not faces. Faces that touch on one line are joined, as a wall
    may be made of many solids.
    """
    if not outlines:
        return _sampled(np.empty((0, 2, 2)))
    return _sampled(_joined(_free_parts(outlines)))


def _free_parts(outlines: Sequence[FloatArray]) -> FloatArray:
    """Return the parts of all edges with free space in front, each with its free side to the left, (F, 2, 2)."""
    edges = np.concatenate([np.stack([np.roll(outline, -1, axis=0), outline], axis=1) for outline in outlines])
    vectors = edges[:, 1] - edges[:, 0]
    lengths = np.maximum(np.hypot(*vectors.T), ROUNDING)
    before = edges + (np.column_stack([-vectors[:, 1], vectors[:, 0]]) * (ASIDE / lengths)[:, None])[:, None]
    edge, solid = _near(before, outlines)
    begin, end = _parts_within(before[edge], solid, outlines)
    hidden = begin < end
    parts = _left_free(edge[hidden], begin[hidden], end[hidden], len(edges))
    of_edge, shares = np.array([e for e, *_ in parts], np.int64), np.array([share for _, *share in parts])
    long_enough = np.diff(shares.reshape(-1, 2))[:, 0] * lengths[of_edge] > ROUNDING
    of_edge, shares = of_edge[long_enough], shares.reshape(-1, 2)[long_enough]
    return np.asarray(edges[of_edge, :1] + shares[:, :, None] * vectors[of_edge, None])


def _near(edges: FloatArray, outlines: Sequence[FloatArray]) -> tuple[IntArray, IntArray]:
    """Return edges (E, 2, 2) and solids whose bounding boxes overlap, (P,) each."""
    low, high = (np.array([bound(outline, axis=0) for outline in outlines]) for bound in (np.min, np.max))
    lower, upper = edges.min(axis=1), edges.max(axis=1)
    from_the_left, found = np.argsort(lower[:, 0], kind="stable"), []
    for first in range(0, len(edges), BLOCK):
        block = from_the_left[first : first + BLOCK]
        beside = np.flatnonzero((low[:, 0] <= upper[block, 0].max()) & (high[:, 0] >= lower[block[0], 0]))
        overlap = np.all((upper[block, None] >= low[beside]) & (lower[block, None] <= high[beside]), axis=2)
        edge, solid = np.nonzero(overlap)
        found.append(np.stack([block[edge], beside[solid]]))
    edge, solid = np.concatenate(found, axis=1)
    return edge, solid


def _parts_within(edges: FloatArray, solid: IntArray, outlines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the shares of each edge (P, 2, 2) between which it is in its convex solid, (P,) each.

    If an edge is never inside, its begin is not below its end.
    """
    begin, end = np.zeros(len(edges)), np.ones(len(edges))
    start, vectors = edges[:, 0], edges[:, 1] - edges[:, 0]
    corners, sizes = np.concatenate(outlines), np.array(list(map(len, outlines)))
    firsts = np.cumsum(sizes) - sizes
    for side in range(sizes.max()):
        at = np.flatnonzero(sizes[solid] > side)
        first, size = firsts[solid[at]], sizes[solid[at]]
        corner = corners[first + side]
        along, to_start = corners[first + (side + 1) % size] - corner, start[at] - corner
        here = along[:, 0] * to_start[:, 1] - along[:, 1] * to_start[:, 0]  # positive to the left: inside
        change = along[:, 0] * vectors[at, 1] - along[:, 1] * vectors[at, 0]
        level = np.abs(change) < 1e-12
        share = -here / np.where(level, 1.0, change)
        enters, leaves, outside = ~level & (change > 0.0), ~level & (change < 0.0), level & (here < 0.0)
        begin[at[enters]] = np.maximum(begin[at[enters]], share[enters])
        end[at[leaves]] = np.minimum(end[at[leaves]], share[leaves])
        end[at[outside]] = 0.0
    return begin, end


def _left_free(edge: IntArray, begin: FloatArray, end: FloatArray, count: int) -> list[tuple[int, float, float]]:
    """Return the parts of the edges that no solid hides, with shares from 0 to 1: index of the edge, begin and end."""
    left = []
    reach = np.zeros(count)
    for k in np.lexsort([begin, edge]):
        at = edge[k]
        if begin[k] > reach[at]:
            left.append((int(at), float(reach[at]), float(begin[k])))
        reach[at] = max(reach[at], end[k])
    return left + [(e, float(reach[e]), 1.0) for e in range(count) if reach[e] < 1.0]


def _joined(parts: FloatArray) -> FloatArray:
    """Join parts that touch or overlap on one line and face the same way."""
    vectors = parts[:, 1] - parts[:, 0]
    along = vectors / np.hypot(*vectors.T)[:, None]
    rho = along[:, 0] * parts[:, 0, 1] - along[:, 1] * parts[:, 0, 0]
    begin, end = (np.sum(along * parts[:, side], axis=1) for side in (0, 1))
    line = np.unique(np.round(np.column_stack([along, rho]), 6) + 0.0, axis=0, return_inverse=True)[1].ravel()
    faces: list[FloatArray] = []
    at, reach = -1, -np.inf
    for k in np.lexsort([begin, line]):
        if line[k] != at or begin[k] > reach + ASIDE:
            faces.append(parts[k].copy())
            at, reach = line[k], end[k]
        elif end[k] > reach:
            faces[-1][1], reach = parts[k, 1], end[k]
    joined = np.array(faces).reshape(-1, 2, 2)
    lengths: FloatArray = np.hypot(*(joined[:, 1] - joined[:, 0]).T)
    return np.asarray(joined[lengths >= SHORTEST])


def _sampled(faces: FloatArray) -> TrueWalls:
    lengths = np.hypot(*(faces[:, 1] - faces[:, 0]).T)
    counts = np.ceil(lengths / SPACING - 1e-9).astype(np.int64)
    face_of = np.repeat(np.arange(len(faces)), counts)
    place = np.arange(len(face_of)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((place + 0.5) / counts[face_of])[:, None]
    samples = (1.0 - share) * faces[face_of, 0] + share * faces[face_of, 1]
    return TrueWalls(faces, samples, face_of, (lengths / np.maximum(counts, 1))[face_of])
