"""Removes the jumps from wheel odometry that was reset during a log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.files.logs.read_statistics import ReadStatistics
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D, compose_poses, relative_poses, wrap_angles

_JUMP: Final = 0.25
_TURN: Final = 0.6
"""Least step between two messages, metres and radians, that is a reset; the matcher corrects smaller ones."""
_STALE: Final = 0.5
"""Seconds for which wheels may repeat the same reading before they catch up."""
_USUAL: Final = 3.0
"""Ratio of a robot's largest speed to its usual one, which is the median while it moves."""
_SPEED: Final = 1.0
_TURNING: Final = 2.0
"""Speeds that are always possible, m/s and rad/s."""
_MOVES: Final = 0.05
"""Least speed that counts as motion, m/s or rad/s."""


class Joined(NamedTuple):
    """Poses without jumps."""

    poses: FloatArray
    """x, y, theta as rows; those before the first jump are unchanged."""
    resets: Sequence[int]
    """Indices of the poses after a jump."""
    lengths: Sequence[float]
    """Sizes of these jumps, metres."""


def join_resets(stamps: FloatArray, poses: FloatArray) -> Joined:
    """Remove the jumps from poses (K, 3) with these stamps; over a jump, the motion before it continues.

    A jump is a step that wheels cannot make: longer, or turning more, than three times the usual speed allows in that
    time, plus up to half a second in which the wheels repeated their reading.
    """
    steps, seconds = _steps(poses), np.maximum(np.diff(stamps), 0.0)
    lengths, turns = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
    stale = _stale(stamps[:-1], (lengths == 0.0) & (turns == 0.0))
    allowed = seconds + stale
    jumps = _too_fast(lengths, seconds, allowed, _JUMP, _SPEED) | _too_fast(turns, seconds, allowed, _TURN, _TURNING)
    if not jumps.any():
        return Joined(poses, (), ())
    resets = (np.flatnonzero(jumps) + 1).tolist()
    joined = poses.copy()
    for index in resets:
        before = Pose2D.from_array(joined[index - 1])
        after = before @ _usual_motion(steps, seconds, jumps, index - 1)
        joined[index:] = _moved(joined[index:], after)
    return Joined(joined, resets, lengths[jumps].tolist())


def note_resets(joined: Joined, seconds: Sequence[float], statistics: ReadStatistics) -> None:
    """Note how often the odometry was reset, and when first and last; ``seconds`` are the times of the poses."""
    first, last = joined.resets[0], joined.resets[-1]
    place = f"at {seconds[first]:.3f} s" + ("" if last == first else f" to {seconds[last]:.3f} s")
    statistics.notes.append(
        f"its odometry was reset {len(joined.resets)} time{'s' * (last != first)}, {place}, first by "
        f"{joined.lengths[0]:.2f} m; the jumps are removed"
    )


def _steps(poses: FloatArray) -> FloatArray:
    """Return the motion from each pose to the next, in the frame of the first of the two, (K - 1, 3)."""
    dx, dy, turn = np.diff(poses, axis=0).T
    c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    return np.column_stack([c * dx + s * dy, c * dy - s * dx, wrap_angles(turn)])


def _stale(stamps: FloatArray, same: NDArray[np.bool_]) -> FloatArray:
    """Return the seconds before each of these steps, up to half a second, in which the pose was constant."""
    changed = np.concatenate([[True], ~same[:-1]])
    since = stamps[np.maximum.accumulate(np.where(changed, np.arange(len(stamps)), 0))]
    return np.minimum(stamps - since, _STALE)


def _too_fast(
    sizes: FloatArray, seconds: FloatArray, allowed: FloatArray, floor: float, always: float
) -> NDArray[np.bool_]:
    rates = sizes[seconds > 0.0] / seconds[seconds > 0.0]
    moving = rates[rates > _MOVES]
    usual = float(np.median(moving)) if len(moving) else 0.0
    return np.asarray(sizes > floor + max(_USUAL * usual, always) * allowed)


def _usual_motion(steps: FloatArray, seconds: FloatArray, jumps: NDArray[np.bool_], step: int) -> Pose2D:
    """Return the motion in that step at the velocity of the last step without a jump, or of the first one."""
    whole = np.flatnonzero(~jumps & (seconds > 0.0))
    if not len(whole):
        return Pose2D()
    near = whole[max(int(np.searchsorted(whole, step)) - 1, 0)]
    return Twist2D.from_motion(Pose2D.from_array(steps[near]), float(seconds[near])).motion(float(seconds[step]))


def _moved(poses: FloatArray, first: Pose2D) -> FloatArray:
    """Transform all poses so that the first is where it should be; headings stay continuous."""
    moved = compose_poses(first.as_array(), relative_poses(poses[0], poses))
    moved[:, 2] = first.theta + (poses[:, 2] - poses[0, 2])
    return moved
