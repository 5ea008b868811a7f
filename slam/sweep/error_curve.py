"""The error along the way: as many numbers for a short run as for a long one."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from slam.pose import path_lengths
from slam.run.results.traces import Traces, pose_errors

STATIONS: Final = 64
"""Places along the way, evenly from its start to its end."""


def error_curve(folder: Path) -> list[float] | None:
    """Metres between estimate and truth at the stations of a run folder's way; None where the truth is not known."""
    traces = Traces.read(folder)
    if traces is None or traces.truth is None:
        return None
    errors = np.hypot(*pose_errors(traces.estimate, traces.truth)[:, :2].T)
    way = path_lengths(traces.truth)
    at = np.linspace(0.0, way[-1], STATIONS)
    return [round(value, 6) for value in np.interp(at, way, errors).tolist()]
