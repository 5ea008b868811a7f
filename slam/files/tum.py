"""Trajectories as TUM text, one pose per line: ``stamp x y z qx qy qz qw``; seconds, metres, unit quaternion.

The format of https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats, which evo reads.
"""

from array import array
from contextlib import closing
from math import cos, inf, sin
from pathlib import Path
from typing import Final

import numpy as np

from slam.errors import LogError
from slam.files.atomic_files import write_atomic
from slam.files.fields import table_row
from slam.files.text_lines import read_lines
from slam.limits import SCANS
from slam.pose import FloatArray, Pose2D, wrap_angle

_COLUMNS: Final = "stamp x y z qx qy qz qw"
_UNIT: Final = 0.01
"""Largest deviation of a quaternion's norm from 1: some files have only four digits."""


def format_tum(stamp: float, pose: Pose2D) -> str:
    """Format one line, without its end: the pose at ``stamp`` seconds, to the micrometre and the nanoradian."""
    half = wrap_angle(pose.theta) / 2.0
    position = f"{pose.x:.6f} {pose.y:.6f} {0:.6f}"
    return f"{stamp:.6f} {position} {0:.9f} {0:.9f} {sin(half):.9f} {cos(half):.9f}"


def write_tum(path: Path, stamps: FloatArray, poses: FloatArray) -> None:
    """Write poses (N, 3) with their stamps (N,), at once or not at all."""
    rows = zip(stamps.tolist(), poses.tolist(), strict=True)
    write_atomic(path, "".join(format_tum(stamp, Pose2D(*pose)) + "\n" for stamp, pose in rows))


def read_tum(path: str | Path) -> tuple[FloatArray, FloatArray]:
    """Read stamps (N,) in seconds, and poses (N, 3): x and y in metres, heading in (-pi, pi] radians.

    z, roll and pitch are dropped; lines that begin with # are comments. Raises LogError, with the line, if a line is
    not a pose, if the stamps do not increase, and if there is no pose.
    """
    stamps, poses, fault = read_tum_so_far(path)
    if fault is not None:
        raise fault
    if not len(stamps):
        raise LogError(f"{path}: no pose in this file; need lines of {_COLUMNS}")
    return stamps, poses


def read_tum_so_far(path: str | Path) -> tuple[FloatArray, FloatArray, LogError | None]:
    """Read stamps and poses up to the first line that is not a pose, or whose stamp does not increase.

    The error of that line is returned with them, if there is one. LogError if the file cannot be read.
    """
    values, last, fault = array("d"), -inf, None
    with closing(read_lines(Path(path))) as lines:
        try:
            for number, line in lines:
                if (words := line.split()) and not words[0].startswith(b"#"):
                    row = _parse(words, f"{path}: line {number}")
                    if row[0] <= last:
                        raise LogError(f"{path}: the stamps do not increase; sort the poses by stamp, one for each")
                    if excess := SCANS.excess(len(values) // len(row) + 1):
                        raise LogError(f"{path}: line {number}: {excess}")
                    values.extend(row)
                    last = row[0]
        except LogError as error:
            fault = error
    table = np.array(values).reshape(-1, 8)
    qx, qy, qz, qw = table[:, 4:].T
    headings = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    return table[:, 0], np.column_stack([table[:, 1:3], headings]), fault


def _parse(words: list[bytes], where: str) -> list[float]:
    values = table_row(words, _COLUMNS, where)
    if abs(np.linalg.norm(values[4:]) - 1.0) > _UNIT:
        raise LogError(f"{where}: qx qy qz qw are not a unit quaternion; need {_COLUMNS}")
    return values
