"""The line segments of a scan: Proc. 1 to 8."""

from __future__ import annotations

import numpy as np

from slam.config import LineConfig
from slam.lines.hopping import hop_by_svd
from slam.lines.hough_line import hough_line
from slam.lines.prefix_sums import runs_and_lines
from slam.lines.segments import IntArray, Segments
from slam.pose import FloatArray


def extract_segments(points: FloatArray, config: LineConfig) -> Segments:
    """Segments of the points (N, 2) of one scan, in beam order, sensor frame: section 3.2."""
    if config.kernel == "svd":
        runs, lines = _by_svd(points, config)
    else:
        runs, lines = runs_and_lines(points, config.sigma_Th, config.psi, config.L_Th, config.split_gap)
    first, last = runs[:, 0], runs[:, 1]
    return Segments(first, last, lines[:, 0], lines[:, 1], points[first], points[last])  # Proc. 8


def _by_svd(points: FloatArray, config: LineConfig) -> tuple[IntArray, FloatArray]:
    """Runs (M, 2) and their (rho, theta), shape (M, 2), as printed."""
    kept = [
        (begin + P, begin + Q)
        for begin, stop in zip(*_pieces(points, config.split_gap), strict=True)
        for P, Q in hop_by_svd(points[begin:stop], config.sigma_Th, config.psi)
        if Q - P + 1 > config.L_Th  # Proc. 7
    ]
    lines = [hough_line(points[P : Q + 1])[:2] for P, Q in kept]
    return np.array(kept, dtype=np.int64).reshape(-1, 2), np.array(lines, dtype=np.float64).reshape(-1, 2)


def _pieces(points: FloatArray, split_gap: float) -> tuple[IntArray, IntArray]:
    """Begins and stops of the pieces without a step longer than ``split_gap`` metres."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    cuts = np.flatnonzero(steps > split_gap) + 1
    return np.concatenate([[0], cuts]), np.concatenate([cuts, [len(points)]])
