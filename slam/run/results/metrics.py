"""Metrics of a run, and of its localisation in a saved map, from the files in its folder."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.lines.range_noise import RangeNoise
from slam.pose import FloatArray
from slam.run.results.traces import Traces, pose_errors

RIGHT: Final = 0.3, float(np.radians(5.0))
"""Largest error of a correct pose, metres and radians."""


def measure(folder: Path) -> dict[str, Any]:
    """Compute the metrics of a run folder.

    Errors only if it has ``groundtruth.tum``, and only ``scans`` = 0 without steps. Errors compare ``T_map_base`` with
    the true pose scan by scan and without alignment: both begin at the same known pose. Those of ``closed_...`` are of
    the final trajectory after loop closing, if there is one.
    """
    traces = Traces.read(folder)
    if traces is None:
        return {"scans": 0}
    stamps, truth = traces.stamps, traces.truth
    metrics: dict[str, Any] = {"scans": len(stamps), "duration_s": round(float(stamps[-1] - stamps[0]), 6)}
    steps = np.diff((traces.final if truth is None else truth)[:, :2], axis=0)
    metrics["path_m"] = round(float(np.hypot(*steps.T).sum()), 4)
    if truth is not None:
        metrics |= _errors(traces.estimate, truth, "") | _errors(traces.odometry, truth, "odometry_")
    if truth is not None and traces.closed is not None:
        metrics |= _errors(traces.closed, truth, "closed_")
    if "closure" in (traces.steps.dtype.names or ()):
        metrics["closures"] = int(traces.jumps.sum())
    return metrics | _work(traces.steps) | _odometry_only(traces) | _base_state(traces.steps)


def _errors(poses: FloatArray, truth: FloatArray, prefix: str) -> dict[str, float]:
    errors = pose_errors(poses, truth)
    distance, heading = np.hypot(errors[:, 0], errors[:, 1]), np.degrees(np.abs(errors[:, 2]))
    values = {
        "ate_rmse_m": np.sqrt(np.mean(distance**2)),
        "ate_max_m": distance.max(),
        "final_m": distance[-1],
        "x_max_abs_m": np.abs(errors[:, 0]).max(),
        "y_max_abs_m": np.abs(errors[:, 1]).max(),
        "heading_max_abs_deg": heading.max(),
        "heading_rmse_deg": np.sqrt(np.mean(heading**2)),
        "heading_final_deg": heading[-1],
    }
    return {prefix + name: round(float(value), 6) for name, value in values.items()}


def _work(steps: NDArray[Any]) -> dict[str, Any]:
    """Compute the cost of the method; iterations and times are those of matched and mapped scans."""
    mapped = steps[steps["mapped"] == 1]
    matched = mapped[mapped["iterations"] > 0]
    slam_ms, extraction_ms = (mapped[name] if len(mapped) else np.zeros(1) for name in ("slam_ms", "extraction_ms"))
    iterations = matched["iterations"] if len(matched) else np.zeros(1)
    return {
        "updates": len(mapped),
        "iterations_mean": round(float(iterations.mean()), 2),
        "iterations_max": int(iterations.max()),
        "not_converged": int((matched["converged"] == 0).sum()),
        "slam_ms_median": round(float(np.median(slam_ms)), 4),
        "slam_ms_p99": round(float(np.percentile(slam_ms, 99)), 4),
        "slam_s_total": round(float(steps["slam_ms"].sum()) / 1e3, 4),
        "extraction_ms_median": round(float(np.median(extraction_ms)), 4),
        "map_points": int(steps["map_points"][-1]),
        "segments": int(steps["segments"].sum()),
    }


def _base_state(steps: NDArray[Any]) -> dict[str, Any]:
    """Compute metrics of the base's own state, as far as it was reported; none for an older run."""
    if "battery" not in (steps.dtype.names or ()):
        return {}
    metrics: dict[str, Any] = {
        "stalled_scans": int((steps["stalled"] == 1).sum()),
        "fault_scans": int((steps["fault_flags"] != 0).sum()),
    }
    volts, nearest = (values[np.isfinite(values)] for values in (steps["battery"], steps["sonar_nearest"]))
    if len(volts):
        metrics |= {"battery_start_v": float(volts[0]), "battery_end_v": float(volts[-1])}
    if len(nearest):
        metrics["sonar_nearest_m"] = float(nearest.min())
    return metrics


def noise_metrics(noise: RangeNoise, named: RangeNoise | None) -> dict[str, float]:
    """Return the learnt noise of the ranges and, if the settings name the sensor, the noise of its near ranges."""
    metrics = {"range_noise_m": noise.near, "range_noise_share": noise.far}
    if named is not None:
        metrics["named_range_noise_m"] = named.near
    return {name: round(value, 6) for name, value in metrics.items()}


def _odometry_only(traces: Traces) -> dict[str, Any]:
    """Count the matched scans whose pose is odometry alone, with their share."""
    count, updates = int(traces.odometry_only.sum()), int((traces.steps["mapped"] == 1).sum())
    return {"odometry_only": count, "odometry_only_share": round(count / max(updates, 1), 4)}


def measure_localization(folder: Path) -> dict[str, Any]:
    """Compute the metrics of a run in a saved map.

    Additional metrics are ``sure_after_s``, ``lost_scans``, and if the true pose is known ``right_after_s``,
    ``wrong_scans`` (sure, and wrong) and the tracking errors of the scans in which the robot was sure.
    """
    metrics, traces = measure(folder), Traces.read(folder)
    if traces is None:
        return metrics
    since, sure = traces.stamps - traces.stamps[0], traces.steps["lost"] == 0
    metrics |= {"sure_after_s": _first(since, sure), "lost_scans": int((~sure).sum())}
    if traces.truth is None:
        return metrics
    errors = pose_errors(traces.estimate, traces.truth)
    distance, turn = np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2])
    right = sure & (distance < RIGHT[0]) & (turn < RIGHT[1])
    metrics |= {"right_after_s": _first(since, right), "wrong_scans": int((sure & ~right).sum())}
    if sure.any():
        metrics["tracking_rmse_m"] = round(float(np.sqrt(np.mean(distance[sure] ** 2))), 6)
        metrics["tracking_max_m"] = round(float(distance[sure].max()), 6)
        metrics["tracking_rmse_deg"] = round(float(np.degrees(np.sqrt(np.mean(turn[sure] ** 2)))), 6)
    return metrics


def _first(since: NDArray[np.float64], are: NDArray[np.bool_]) -> float | None:
    """Return the seconds to the first scan in the mask ``are``; None for never."""
    return round(float(since[np.argmax(are)]), 6) if are.any() else None
