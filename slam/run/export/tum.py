"""The estimated trajectory as TUM text, which evo reads."""

from __future__ import annotations

from pathlib import Path

from slam.files.tum import format_tum
from slam.files.whole_files import write_whole
from slam.pose import Pose2D
from slam.run.results.run_record import RunRecord


def write(record: RunRecord, out: Path) -> None:
    """One line a scan: ``stamp x y z qx qy qz qw``, map frame."""
    rows = zip(record.traces.stamps.tolist(), record.traces.estimate, strict=True)
    write_whole(out, "".join(format_tum(stamp, Pose2D.from_array(pose)) + "\n" for stamp, pose in rows))
