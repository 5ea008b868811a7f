"""Writes a run into its folder scan by scan, so that the results survive any end of the program."""

from contextlib import ExitStack
from math import inf
from pathlib import Path
from typing import Any, Final

import numpy as np

from slam.closing import Closing
from slam.files.atomic_files import GrowingGeoJson, GrowingText, line_feature
from slam.files.tum import format_tum
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.step import Step

STEP_COLUMNS: Final = (
    "stamp", "mapped", "iterations", "converged", "map_points", "segments", "extraction_ms", "slam_ms", "v", "omega",
    "lost", "cov_xx", "cov_xy", "cov_xth", "cov_yy", "cov_yth", "cov_thth", "odometry_only",
    "local_x", "local_y", "local_theta", "closure", "stalled", "battery", "fault_flags", "sonar_nearest",
)  # fmt: skip
_UPPER: Final = np.triu_indices(3)


class Recorder(Closing):
    """Watcher that writes ``trajectory.tum``, ``odometry.tum``, ``groundtruth.tum``, ``steps.csv``, ``lines.geojson``.

    Poses are ``T_map_base``; odometry starts at the robot's first estimate.
    """

    def __init__(self, folder: Path, T_map_odom: Pose2D, T_base_laser: Pose2D) -> None:
        self._folder, self._T_map_odom, self._T_base_laser = folder, T_map_odom, T_base_laser
        self._trajectory = GrowingText(folder / "trajectory.tum")
        self._odometry = GrowingText(folder / "odometry.tum")
        self._truth: GrowingText | None = None
        self._steps = GrowingText(folder / "steps.csv", ",".join(STEP_COLUMNS) + "\n")
        self._lines = GrowingGeoJson(folder / "lines.geojson", frame="map", unit="metre")

    def on_step(self, step: Step) -> None:
        """Write one step."""
        odometry, estimate = step.observation.odometry, step.estimate
        self._trajectory.append(format_tum(estimate.stamp, estimate.T_map_base) + "\n")
        self._odometry.append(format_tum(estimate.stamp, self._T_map_odom @ odometry.T_odom_base) + "\n")
        if step.observation.T_map_base is not None:
            self._truth = self._truth or GrowingText(self._folder / "groundtruth.tum")
            self._truth.append(format_tum(estimate.stamp, step.observation.T_map_base) + "\n")
        if estimate.segments is not None:
            self._lines.append(self._features(step))
        self._steps.append(self._row(step))

    def close(self) -> None:
        """Sync everything to the disk."""
        with ExitStack() as files:
            for file in (self._trajectory, self._odometry, self._truth, self._steps, self._lines):
                if file is not None:
                    files.callback(file.close)

    def _row(self, step: Step) -> str:
        estimate, match, local = step.estimate, step.estimate.match, step.estimate.T_local_base
        values = (
            f"{estimate.stamp:.6f}", int(estimate.mapped), match.iterations, int(match.converged), estimate.map_points,
            len(estimate.segments) if estimate.segments is not None else 0, f"{1e3 * estimate.extraction_time:.4f}",
            f"{1e3 * estimate.total_time:.4f}", f"{step.applied.linear:.6f}", f"{step.applied.angular:.6f}",
            int(estimate.lost), *_covariance(estimate.covariance), int(estimate.odometry_only),
            f"{local.x:.6f}", f"{local.y:.6f}", f"{local.theta:.9f}",
            -1 if estimate.closure is None else estimate.closure.submap, *_base_state(step.observation),
        )  # fmt: skip
        return ",".join(map(str, values)) + "\n"

    def _features(self, step: Step) -> list[dict[str, Any]]:
        """Make one LineString per segment, from its start to its end point, metres in the map frame."""
        segments = step.estimate.segments
        assert segments is not None
        in_map = segments.transformed(step.estimate.T_map_base @ self._T_base_laser)
        return [
            line_feature([_rounded(start), _rounded(end)], {"scan": step.index, "points": int(count)})
            for start, end, count in zip(in_map.start, in_map.end, segments.counts, strict=True)
        ]


def _base_state(seen: Observation) -> list[int | str]:
    """Return the state that the base reports, in the order of the columns; empty if unknown."""
    battery = "" if seen.battery is None else f"{seen.battery.volts:.1f}"
    nearest = min(seen.sonar, default=inf)
    return [int(seen.stalled), battery, seen.fault_flags, f"{nearest:.3f}" if nearest < inf else ""]


def _rounded(point: Any) -> list[float]:
    """Round a point, metres, to a tenth of a millimetre."""
    return [round(float(value), 4) for value in point]


def _covariance(covariance: FloatArray | None) -> list[str]:
    """Return the upper triangle of the covariance, row by row; empty without one."""
    return [""] * 6 if covariance is None else [f"{value:.9g}" for value in covariance[_UPPER]]
