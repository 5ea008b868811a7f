"""Removes poses that no wheels can have driven to and back from, such as garbled numbers."""

from collections.abc import Callable, Sequence
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from slam.limits import FROM_START, STEP
from slam.pose import FloatArray

_FASTEST: Final = 15.0
"""Largest believable speed, m/s."""
_LONGEST_GAP: Final = 60.0
"""Longest believable time between two stamps, seconds."""
_AHEAD: Final = 10
"""Number of poses within which the path returns from an outlier; a path that does not return is a new start."""
Row = TypeVar("Row")


def drop_outliers(
    rows: Sequence[Row],
    pose_of: Callable[[Row], tuple[float, float, float]],
    skip: Callable[[Row], None],
    notes: list[str],
) -> list[Row]:
    """Drop the rows with outlying poses. ``pose_of`` gives stamp, x and y, seconds and metres.

    ``skip`` is called for each outlier; a note states the distance of the first one, and the limit.
    """
    if len(rows) < 2:
        return list(rows)
    table = np.array([pose_of(row) for row in rows])
    out = outliers(table[:, 0], table[:, 1:])
    for index in np.flatnonzero(out).tolist():
        skip(rows[index])
    if out.any():
        first = int(np.argmax(out))
        away = float(np.hypot(*(table[first, 1:] - table[np.argmin(out), 1:])))
        notes.append(f"an outlying pose lies {(FROM_START.excess(away) or STEP.excess(away))}")
    return [row for row, is_out in zip(rows, out.tolist(), strict=True) if not is_out]


def outliers(stamps: FloatArray, positions: FloatArray) -> NDArray[np.bool_]:
    """Return True for the positions (N, 2) that are outliers, (N,).

    Their distance from their neighbours is more than wheels can drive, or they are too far from the start.
    """
    out = np.zeros(len(stamps), np.bool_)
    last = 0
    suspects = _suspects(stamps, positions)
    jumps = set(suspects)
    for k in suspects:
        if k <= last or out[k]:
            continue
        last = k - 1 if not out[k - 1] else last
        near = range(k + 1, min(k + 1 + _AHEAD, len(stamps)))
        later = [j for j in near if j in jumps and _within_reach(stamps, positions, last, j)]  # the path jumps back
        if later:
            out[k : later[0]] = True
        elif k < min(_AHEAD, len(stamps) - k):
            out[:k] = True  # the start itself is the outlier
        last = max(last, later[0] if later else k)
    start = positions[np.argmin(out)]
    far: NDArray[np.bool_] = np.hypot(*(positions - start).T) > FROM_START.most
    return out | far


def _suspects(stamps: FloatArray, positions: FloatArray) -> list[int]:
    """Return the indices of the positions that cannot be reached from the one before."""
    reach = STEP.most + _FASTEST * np.clip(np.diff(stamps), 0.0, _LONGEST_GAP)
    found: list[int] = (1 + np.flatnonzero(np.hypot(*np.diff(positions, axis=0).T) > reach)).tolist()
    return found


def _within_reach(stamps: FloatArray, positions: FloatArray, first: int, second: int) -> bool:
    seconds = min(max(float(stamps[second] - stamps[first]), 0.0), _LONGEST_GAP)
    return float(np.hypot(*(positions[second] - positions[first]))) <= STEP.most + _FASTEST * seconds
