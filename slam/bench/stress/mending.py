"""Odometry that has lost the sign of its backward motions, mended by a reference.

The wheel odometry of fr079 is such a one: it drives forwards wherever the robot drove backwards.
"""

from typing import Final

import numpy as np

from slam.bench.stress.wheel_faults import motions, with_motions
from slam.files.logs import Log
from slam.pose import FloatArray, relative_poses
from slam.run.scoring.pose_errors import poses_at

_BACKWARDS: Final = -0.05
"""Metres along three steps of the reference from which it drives backwards: single steps of it jitter."""


def mended(log: Log, times: FloatArray, truth: FloatArray) -> Log:
    """The log with the motions turned round where the reference, ``truth`` (K, 3) at ``times`` (K,), drives backwards
    and the odometry forwards."""
    moves, true = motions(log.T_odom_base), poses_at(log.stamps, times, truth).poses
    step = np.arange(len(moves))
    before, after = np.maximum(step - 1, 0), np.minimum(step + 2, len(moves))
    along = relative_poses(true[before], true[after])[:, 0]
    moves[(along < _BACKWARDS) & (moves[:, 0] > 0.0), :2] *= -1.0
    return with_motions(log, moves)
