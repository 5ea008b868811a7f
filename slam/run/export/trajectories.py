"""The trajectory of a run as TUM text, and the data of every scan as one CSV table."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from slam.files.atomic_files import write_atomic
from slam.files.tum import format_tum
from slam.pose import FloatArray, Pose2D
from slam.run.results.run_record import RunRecord


def write_tum(record: RunRecord, out: Path) -> None:
    """Write one line per scan: ``stamp x y z qx qy qz qw``, map frame, with the final poses after loop closing."""
    rows = zip(record.traces.stamps.tolist(), record.traces.final.tolist(), strict=True)
    write_atomic(out, "".join(format_tum(stamp, Pose2D(*pose)) + "\n" for stamp, pose in rows))


def write_csv(record: RunRecord, out: Path) -> None:
    """Write a table of the trajectories: stamp, x, y, theta of each, then the columns of ``steps.csv``.

    The trajectories are the one estimated during the run, the final one if loops were closed, dead reckoning and, if
    known, the true one. Metres, radians, seconds, map frame.
    """
    traces, names = record.traces, list(record.traces.steps.dtype.names or ())[1:]
    columns = [traces.stamps[:, None], *(poses for _, poses in _trajectories(record))]
    table = np.hstack([*columns, np.column_stack([traces.steps[name] for name in names])])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["stamp", *(p + c for p, _ in _trajectories(record) for c in ("x", "y", "theta")), *names])
    writer.writerows([["" if np.isnan(value) else f"{value:.10g}" for value in row] for row in table])
    write_atomic(out, text.getvalue())


def _trajectories(record: RunRecord) -> Iterator[tuple[str, FloatArray]]:
    """Yield the prefix of the columns, and the poses (K, 3), of each trajectory."""
    yield "", record.traces.estimate
    if record.traces.closed is not None:
        yield "closed_", record.traces.closed
    yield "odometry_", record.traces.odometry
    if record.traces.truth is not None:
        yield "truth_", record.traces.truth
