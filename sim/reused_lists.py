"""A mesh as the lists that PyBullet takes, from objects that are used again for the next one.

PyBullet 3.2.7 never lets go of the rows and numbers that a collision shape is made from, 0.1 MB for a corridor with 40
boxes. Lent to it again and again, they are kept once.
"""

from __future__ import annotations

from itertools import count, islice

from sim.mesh import Mesh

_rows: list[list[float]] = []
_numbers: list[int] = []


def reused_lists(mesh: Mesh) -> tuple[list[list[float]], list[int]]:
    """Vertices and indices; good until the next call."""
    missing = len(mesh.vertices) - len(_rows)
    _rows.extend([] for _ in range(missing))
    _numbers.extend(islice(count(len(_numbers)), max(missing, 0)))
    rows = _rows[: len(mesh.vertices)]
    for row, vertex in zip(rows, mesh.vertices.tolist(), strict=True):
        row[:] = vertex
    return rows, [_numbers[index] for index in mesh.triangles.ravel().tolist()]
