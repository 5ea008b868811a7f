"""The graph of a run in the format of g2o, which GTSAM and most other solvers read too.

In g2o the error of an edge is measured^-1 (first^-1 second), in the axes of the second node; ours is in those of the
first, so the information is rotated. That of a loop is multiplied by the loop's weight: so a solver without a robust
kernel finds the same poses.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from slam.errors import InputError
from slam.files.atomic_files import write_atomic
from slam.graph.pose_graph import Edges
from slam.graph.run_graph import RunGraph
from slam.pose import FloatArray
from slam.run.results.run_record import RunRecord

_UPPER: Final = np.triu_indices(3)


def write_g2o(record: RunRecord, out: Path) -> None:
    """Write ``VERTEX_SE2``, ``FIX`` and ``EDGE_SE2``: nodes of submaps and key scans, poses of the laser, map frame.

    InputError for a run without a graph.
    """
    if record.graph is None:
        raise InputError(f"{record.folder}: has no graph.json: no loops were closed; try hopslam optimize")
    write_atomic(out, "".join(line + "\n" for line in _rows(record.graph)))


def _rows(graph: RunGraph) -> Iterator[str]:
    for number, pose in enumerate(graph.nodes.tolist()):
        yield f"VERTEX_SE2 {number} {_numbers(pose)}"
    yield "FIX 0"
    edges = graph.edges
    information = graph.edge_weights[:, None, None] * turned_to_second(edges)
    for first, second, measured, rows in zip(
        edges.first, edges.second, edges.measured.tolist(), information, strict=True
    ):
        yield f"EDGE_SE2 {first} {second} {_numbers(measured)} {_numbers(rows[_UPPER].tolist())}"


def turned_to_second(edges: Edges) -> FloatArray:
    """Return the information (E, 3, 3) in the axes of the second nodes, the convention of g2o."""
    c, s = np.cos(edges.measured[:, 2]), np.sin(edges.measured[:, 2])
    R = np.zeros((len(c), 3, 3))
    R[:, 0, 0], R[:, 0, 1], R[:, 1, 0], R[:, 1, 1], R[:, 2, 2] = c, -s, s, c, 1.0
    return np.asarray(R.transpose(0, 2, 1) @ edges.information @ R)


def _numbers(values: list[float]) -> str:
    return " ".join(map(repr, values))
