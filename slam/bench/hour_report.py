"""``hopslam bench slam-sim --hour``: whether cost and memory stay what they were."""

from __future__ import annotations

from typing import Final

import numpy as np

from slam.bench.sim_runs import HOUR, SimRun
from slam.console.result_table import ResultTable

BLOCK: Final = 1000
"""Scans at the beginning and at the end that are compared."""
PARTS: Final = 12
"""Of the run: each five minutes, in an hour."""


def hour_tables(run: SimRun) -> list[ResultTable]:
    """The first scans beside the last, and the map over time."""
    return [_cost(run), _growth(run)]


def _cost(run: SimRun) -> ResultTable:
    columns = ("scans", "first 1,000\nms", "p99", "last 1,000\nms", "p99", "ratio", "end\ncm", "most\ncm")
    first, last = run.times[:BLOCK], run.times[-BLOCK:]
    errors = 100.0 * np.hypot(*run.offsets[:, :2].T)
    row = (
        str(len(run.times)), *_milliseconds(first), *_milliseconds(last), f"{np.median(last) / np.median(first):.2f}",
        f"{errors[-1]:.1f}", f"{errors.max():.1f}",
    )  # fmt: skip
    return ResultTable("One hour", columns, [row], "Around and around. The first 1,000 scans make the map.")


def _growth(run: SimRun) -> ResultTable:
    ends = [len(run.times) * part // PARTS for part in range(1, PARTS + 1)]
    rows = [
        (
            f"{end / len(run.times) * HOUR / 60.0:.0f} min", f"{run.map_points[end - 1]:.0f}",
            f"{run.map_bytes[end - 1] / 1e3:.0f}", *_milliseconds(run.times[begin:end]),
        )
        for begin, end in zip([0, *ends], ends, strict=False)
    ]  # fmt: skip
    return ResultTable("The map in that hour", ("after", "surfels", "kB", "ms", "p99"), rows)


def _milliseconds(times: np.ndarray) -> tuple[str, str]:
    """Median and 99th percentile."""
    return f"{1e3 * np.median(times):.3f}", f"{1e3 * np.percentile(times, 99):.2f}"
