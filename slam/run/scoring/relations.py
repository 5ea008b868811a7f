"""Errors against relations known by hand: Kuemmerle et al., Autonomous Robots 27, 2009."""

from contextlib import closing
from pathlib import Path

import numpy as np

from slam.errors import LogError
from slam.files.fields import table_row
from slam.files.text_lines import read_lines
from slam.pose import FloatArray, relative_poses
from slam.run.scoring.pose_errors import MAX_GAP, PoseErrors, poses_at

_COLUMNS = "t1 t2 x y z roll pitch yaw"


def read_relations(path: Path) -> FloatArray:
    """Rows t1, t2, x, y, yaw, seconds, metres and radians, of a file of lines ``t1 t2 x y z roll pitch yaw``, plain or
    gzip. LogError, naming the line, for another one."""
    with closing(read_lines(path)) as lines:
        rows = [
            table_row(words, _COLUMNS, f"{path}: line {number}") for number, line in lines if (words := line.split())
        ]
    if not rows:
        raise LogError(f"{path}: no relation in this file; need lines of {_COLUMNS}")
    return np.array(rows)[:, [0, 1, 2, 3, 7]]


def relation_errors(relations: FloatArray, stamps: FloatArray, poses: FloatArray, gap: float = MAX_GAP) -> PoseErrors:
    """Errors of every relation whose two times the trajectory covers."""
    first, second = (poses_at(relations[:, column], stamps, poses, gap) for column in (0, 1))
    errors = relative_poses(relations[:, 2:], relative_poses(first.poses, second.poses))[first.known & second.known]
    return PoseErrors(np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2]))
