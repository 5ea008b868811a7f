"""Errors against relations known by hand: Kuemmerle et al., Autonomous Robots 27, 2009."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np

from slam.errors import LogError
from slam.files.logs.log import relative_poses
from slam.files.text_lines import read_lines
from slam.files.tum import parse_row
from slam.pose import FloatArray
from slam.run.scoring.pose_errors import PoseErrors
from slam.run.scoring.poses_at import MAX_GAP, poses_at

_COLUMNS = "t1 t2 x y z roll pitch yaw"


def read_relations(path: Path) -> FloatArray:
    """Rows t1, t2, x, y, yaw, seconds, metres and radians, of a file of lines ``t1 t2 x y z roll pitch yaw``, plain or
    gzip. LogError, naming the line, for another one."""
    with closing(read_lines(path)) as lines:
        words = ((line.split(), f"{path}: line {number}") for number, line in lines)
        rows = [parse_row(row, _COLUMNS, where) for row, where in words if row]
    if not rows:
        raise LogError(f"{path}: no relation in this file; need lines of {_COLUMNS}")
    return np.array(rows)[:, [0, 1, 2, 3, 7]]


def relation_errors(relations: FloatArray, stamps: FloatArray, poses: FloatArray, gap: float = MAX_GAP) -> PoseErrors:
    """Of every relation whose two times the trajectory covers."""
    first, second = (poses_at(relations[:, column], stamps, poses, gap) for column in (0, 1))
    errors = relative_poses(relations[:, 2:], relative_poses(first.poses, second.poses))[first.known & second.known]
    return PoseErrors(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]))
