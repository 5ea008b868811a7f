"""One triangle mesh of the prisms of a world plan, and its lists for PyBullet."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, islice

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray
from slam.scenario.solids import Prism


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """``vertices`` (V, 3) in metres, and ``triangles`` (T, 3) of indices into them, counter-clockwise from outside."""

    vertices: FloatArray
    triangles: NDArray[np.int64]


def _prism_triangles(corners: int) -> NDArray[np.int64]:
    """Return the triangles (4 N - 4, 3) of a prism over N corners.

    Vertices 0 to N - 1 are its bottom, N to 2 N - 1 its top.
    """
    here = np.arange(corners)
    there = (here + 1) % corners
    sides = np.column_stack([here, there, there + corners, here, there + corners, here + corners]).reshape(-1, 3)
    fan = np.column_stack([np.zeros(corners - 2, dtype=np.int64), here[1:-1], there[1:-1]])
    return np.concatenate([sides, fan[:, ::-1], fan + corners])


def _prism_vertices(prism: Prism) -> FloatArray:
    """Return the vertices (2 N, 3), the bottom ring first."""
    bottom, top = (np.insert(prism.footprint, 2, z, axis=1) for z in (prism.bottom, prism.top))
    return np.concatenate([bottom, top])


def extrude(prisms: Sequence[Prism]) -> Mesh:
    """Join all these solids in one mesh; each keeps its own closed surface, even if two overlap."""
    vertices = [_prism_vertices(prism) for prism in prisms]
    first = np.cumsum([0, *map(len, vertices)])
    triangles = [_prism_triangles(len(ring) // 2) + start for ring, start in zip(vertices, first, strict=False)]
    return Mesh(
        np.concatenate([np.empty((0, 3)), *vertices]),
        np.concatenate([np.empty((0, 3), dtype=np.int64), *triangles]),
    )


_rows: list[list[float]] = []
_numbers: list[int] = []
"""PyBullet 3.2.7 never frees the lists that a collision shape is made from, 0.1 MB for a corridor with 40 boxes. If it
gets the same lists again, it keeps them only once."""


def reused_lists(mesh: Mesh) -> tuple[list[list[float]], list[int]]:
    """Return vertices and indices in lists that the next call overwrites."""
    missing = len(mesh.vertices) - len(_rows)
    _rows.extend([] for _ in range(missing))
    _numbers.extend(islice(count(len(_numbers)), max(missing, 0)))
    rows = _rows[: len(mesh.vertices)]
    for row, vertex in zip(rows, mesh.vertices.tolist(), strict=True):
        row[:] = vertex
    return rows, [_numbers[index] for index in mesh.triangles.ravel().tolist()]
