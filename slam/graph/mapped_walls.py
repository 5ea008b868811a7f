"""The walls of the closed map, each with the uncertainty of its wall in the graph."""

from typing import Final, NamedTuple

import numpy as np

from slam.graph.closure import ClosedRun
from slam.pose import FloatArray

FACING: Final = 0.98
"""Least cosine between a wall of the map and one of the graph."""
BESIDE: Final = 0.05
"""Largest distance between them at the middle of the former, metres."""


class MappedWalls(NamedTuple):
    """M walls of the line map."""

    ends: FloatArray
    """(M, 2, 2): [wall, start or end, x or y]; metres, map frame, the lidar to the left."""
    sigmas: FloatArray
    """(M, 2): standard deviations across the wall at its middle (m) and of its direction (rad), against the truth; nan
    for a wall that no two key scans share."""


def mapped_walls(run: ClosedRun) -> MappedWalls:
    """Return the walls of the map of a closed run."""
    ends, landmarks = run.map.ends, run.walls.ends
    sigmas = np.full((len(ends), 2), np.nan)
    if len(landmarks):
        middles, directions, lengths = _lines(landmarks)
        for k, (middle, direction, _) in enumerate(zip(*_lines(ends), strict=True)):
            offset = middle - middles
            along, across = (
                (offset * directions).sum(axis=1),
                directions[:, 0] * offset[:, 1] - directions[:, 1] * offset[:, 0],
            )
            fits = (directions @ direction > FACING) & (np.abs(across) < BESIDE) & (np.abs(along) < 0.5 * lengths)
            if fits.any():
                best = int(np.argmax(np.where(fits, lengths, 0.0)))
                sigmas[k] = _sigmas(run.wall_covariances[best], float(along[best]))
    return MappedWalls(ends, sigmas)


def _lines(ends: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middles (M, 2), unit directions (M, 2) and lengths (M,) of walls."""
    along = ends[:, 1] - ends[:, 0]
    lengths = np.hypot(along[:, 0], along[:, 1])
    return ends.mean(axis=1), along / np.maximum(lengths, 1e-12)[:, None], lengths


def _sigmas(covariance: FloatArray, along: float) -> FloatArray:
    """Return the standard deviations (2,) of a line at a distance along it from the point of its covariance (2, 2)."""
    J = np.array([[1.0, along], [0.0, 1.0]])
    return np.asarray(np.sqrt(np.maximum(np.diag(J @ covariance @ J.T), 0.0)))
