"""All that is known of every scan as one table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from slam.files.whole_files import write_whole
from slam.pose import FloatArray
from slam.run.results.run_record import RunRecord


def write(record: RunRecord, out: Path) -> None:
    """Columns: stamp, then x, y, theta as estimated, as dead reckoning and, where known, as true; then those of
    ``steps.csv``. Metres, radians, seconds, map frame."""
    traces, names = record.traces, list(record.traces.steps.dtype.names or ())[1:]
    columns = [traces.stamps[:, None], *(poses for _, poses in _trajectories(record))]
    table = np.hstack([*columns, np.column_stack([traces.steps[name] for name in names])])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["stamp", *(p + c for p, _ in _trajectories(record) for c in ("x", "y", "theta")), *names])
    writer.writerows([["" if np.isnan(value) else f"{value:.10g}" for value in row] for row in table])
    write_whole(out, text.getvalue())


def _trajectories(record: RunRecord) -> Iterator[tuple[str, FloatArray]]:
    """Prefix of the columns, and poses (K, 3)."""
    yield "", record.traces.estimate
    yield "odometry_", record.traces.odometry
    if record.traces.truth is not None:
        yield "truth_", record.traces.truth
