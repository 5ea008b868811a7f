"""How good localisation in a saved map was: numbers read back from the run's folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.run.results.metrics import measure
from slam.run.results.traces import Traces, pose_errors

RIGHT: Final = 0.3, float(np.radians(5.0))
"""A pose is right when it is no farther from the true one, metres and radians."""


def measure_localization(folder: Path) -> dict[str, Any]:
    """The metrics of a run, and: ``sure_after_s``, ``lost_scans``, and where the truth is known ``right_after_s``,
    ``wrong_scans`` (sure, and wrong) and the tracking errors of the scans in which the robot was sure."""
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
    """Seconds to the first scan of which it is so; None for never."""
    return round(float(since[np.argmax(are)]), 6) if are.any() else None
