"""Correct and wrong loops: the measured motion between two scans, against a reference."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.graph.closure import ClosedRun
from slam.graph.loop import Loop
from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses, inverse_poses, relative_poses
from slam.run.scoring.pose_errors import InterpolatedPoses, PoseErrors

WRONG_METRES: Final = 0.5
"""A loop is wrong if its position error is above this, metres."""
WRONG_RADIANS: Final = np.radians(6.0)
"""A loop is wrong if its heading error is above this, radians."""
BELIEVED: Final = 0.5
"""The graph accepts a loop whose edges have more than this weight."""
PAIRS: Final = 6
"""Pairs of scans by which a loop is judged."""


class LoopCounts(NamedTuple):
    """Numbers of loops of a run."""

    tried: int
    """Pairs of submaps that were compared."""
    accepted: int
    """Loops that were found."""
    judged: int
    """Found loops whose scans the reference covers."""
    wrong: int
    """Covered loops that are wrong."""
    believed: int
    """Loops that the graph accepts."""
    believed_wrong: int
    """Accepted loops that are wrong."""


def count_loops(closed: ClosedRun, reference: InterpolatedPoses) -> LoopCounts:
    """Count the loops of a run, with the reference (N,) at every scan of it."""
    errors = loop_errors(closed, reference)
    wrong = is_wrong(errors)
    believed = closed.weights > BELIEVED
    judged = np.isfinite(errors.metres)
    counts = judged.sum(), wrong.sum(), believed.sum(), (wrong & believed).sum()
    return LoopCounts(closed.size.tried, len(closed.loops), *map(int, counts))


def is_wrong(errors: PoseErrors) -> NDArray[np.bool_]:
    """Mask (L,) of the wrong loops; loops that could not be judged are not among them."""
    return np.asarray((errors.metres > WRONG_METRES) | (errors.radians > WRONG_RADIANS))


def loop_errors(closed: ClosedRun, reference: InterpolatedPoses) -> PoseErrors:
    """Return the median errors (L,) of each loop between pairs of its scans.

    The error is nan if the reference covers none of them.
    """
    rows = [_errors_of(loop, closed, reference) for loop in closed.loops]
    metres, radians = np.array(rows).reshape(-1, 2).T
    return PoseErrors(metres, radians)


def measured_motions(loop: Loop, closed: ClosedRun) -> tuple[IntArray, IntArray, FloatArray]:
    """Return P pairs of key scans and their motions: scans of the other submap (P,) and of this one (P,), poses (P, 3).

    Each scan is paired with the nearest one of the other submap, as the loop places them; the PAIRS nearest pairs are
    kept. The motion is the pose of the laser at the scan of this submap, in the frame of the laser at the other scan.
    """
    of = {submap.number: np.array(submap.keys, np.int64) for submap in closed.submaps}
    own, others = of[loop.submap], of[loop.other]
    moved = compose_poses(loop.T_other_submap, closed.local[own])
    gaps = np.hypot(*(moved[:, None, :2] - closed.local[others][None, :, :2]).transpose(2, 0, 1))
    nearest = gaps.argmin(axis=1)
    chosen = np.argsort(gaps.min(axis=1), kind="stable")[:PAIRS]
    paired = others[nearest[chosen]]
    return paired, own[chosen], relative_poses(closed.local[paired], moved[chosen])


def _errors_of(loop: Loop, closed: ClosedRun, reference: InterpolatedPoses) -> tuple[float, float]:
    first, second, laser = measured_motions(loop, closed)
    to_base = inverse_poses(closed.T_base_laser)
    measured = compose_poses(compose_poses(closed.T_base_laser, laser), np.broadcast_to(to_base, laser.shape))
    a, b = closed.indices[first], closed.indices[second]
    known = reference.known[a] & reference.known[b]
    if not known.any():
        return np.nan, np.nan
    true = relative_poses(reference.poses[a], reference.poses[b])
    errors = relative_poses(true, measured)[known]
    return float(np.median(np.hypot(*errors[:, :2].T))), float(np.median(np.abs(errors[:, 2])))
