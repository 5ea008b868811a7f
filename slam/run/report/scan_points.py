"""The points of the scans that were mapped, as the paper's figures show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slam.pose import FloatArray, Pose2D
from slam.run.results.run_record import RunRecord


@dataclass(frozen=True, slots=True, eq=False)
class ScanPoints:
    """Of a run: which scans were mapped, and what they saw."""

    scans: list[int]
    points: list[FloatArray]
    """(N, 2) each, metres, sensor frame."""
    T_base_laser: Pose2D

    def placed(self, poses: FloatArray, before: int | None = None) -> FloatArray:
        """All points (N, 2) with the robot at ``poses`` (K, 3), one for each scan of the run; or those of the scans
        ``before`` one."""
        parts = [
            (Pose2D.from_array(poses[k]) @ self.T_base_laser).transform(points)
            for k, points in zip(self.scans, self.points, strict=True)
            if before is None or k < before
        ]
        return np.concatenate([np.empty((0, 2)), *parts])


def scan_points(record: RunRecord) -> ScanPoints:
    """Read them from the log of the run; InputError where it has none."""
    mapped = record.traces.steps["mapped"] == 1
    seen = [(k, o.scan.points()) for k, (o, use) in enumerate(zip(record.observations(), mapped, strict=False)) if use]
    return ScanPoints([k for k, _ in seen], [points for _, points in seen], record.T_base_laser)
