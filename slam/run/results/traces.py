"""Reads trajectories and step table of a run from its folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from slam.errors import InputError
from slam.files.tum import read_tum_so_far
from slam.pose import FloatArray, compose_poses, relative_poses, wrap_angles
from slam.run.results.step_table import read_steps

SAME_STAMP: Final = 1e-5
"""Largest difference between two stamps of one scan, seconds; files round to the microsecond."""


@dataclass(frozen=True, slots=True, eq=False)
class Traces:
    """K steps: those that all files of the run have, so that an interrupted run can be read too."""

    stamps: FloatArray
    """(K,) seconds."""
    estimate: FloatArray
    """(K, 3): x, y (m), heading (rad) of ``T_map_base`` estimated by SLAM."""
    odometry: FloatArray
    """(K, 3): the same by dead reckoning."""
    truth: FloatArray | None
    """(K, 3): the true ``T_map_base``, if known."""
    steps: NDArray[Any]
    """(K,): records with the columns of ``steps.csv``."""
    closed: FloatArray | None = None
    """(K, 3): final ``T_map_base`` after loop closing; None if no loop was closed, or the run was interrupted."""
    damage: tuple[str, ...] = ()
    """A sentence for each damaged file; its rows after the damage, and the same rows of the others, are left out."""

    @property
    def final(self) -> FloatArray:
        """(K, 3): the best known ``T_map_base``, the final one if loops were closed."""
        return self.estimate if self.closed is None else self.closed

    @property
    def local(self) -> FloatArray | None:
        """(K, 3): ``T_local_base`` by odometry and matching without loop closing; None for an older run."""
        if "local_x" not in (self.steps.dtype.names or ()):
            return None
        return np.column_stack([self.steps[name] for name in ("local_x", "local_y", "local_theta")])

    @property
    def odometry_only(self) -> NDArray[np.bool_]:
        """True for a scan that was matched and rejected, (K,).

        Its pose is odometry alone. It is False for skipped scans, and in older runs, which did not record it.
        """
        if "odometry_only" not in (self.steps.dtype.names or ()):
            return np.zeros(len(self.steps), np.bool_)
        return np.asarray((self.steps["odometry_only"] == 1) & (self.steps["mapped"] == 1))

    @property
    def volts(self) -> FloatArray:
        """(K,): voltage of the base's battery; nan if unknown."""
        if "battery" not in (self.steps.dtype.names or ()):
            return np.full(len(self.steps), np.nan)
        return np.asarray(self.steps["battery"])

    @property
    def jumps(self) -> NDArray[np.bool_]:
        """True for a scan at which a closure was applied: pose and map changed as a whole, (K,)."""
        if "closure" not in (self.steps.dtype.names or ()):
            return np.zeros(len(self.steps), np.bool_)
        return np.asarray(self.steps["closure"] >= 0)

    @property
    def closures(self) -> dict[int, int] | None:
        """The submap whose closure was applied, by the index of the scan; None for a run that did not record it."""
        if "closure" not in (self.steps.dtype.names or ()):
            return None
        return {int(k): int(self.steps["closure"][k]) for k in np.flatnonzero(self.jumps)}

    @classmethod
    def read(cls, folder: Path) -> Self | None:
        """Read the traces of a run folder, up to the first damage of its files; None without a step."""
        if not _has_lines(folder / "trajectory.tum", 1) or not _has_lines(folder / "steps.csv", 2):
            return None
        truth_file = folder / "groundtruth.tum"
        stamps, estimate, *fault = read_tum_so_far(folder / "trajectory.tum")
        _, odometry, *odometry_fault = read_tum_so_far(folder / "odometry.tum")
        steps, *steps_fault = read_steps(folder / "steps.csv")
        _, truth, *truth_fault = read_tum_so_far(truth_file) if truth_file.is_file() else (stamps, None)
        K = min(map(len, (stamps, odometry, steps, stamps if truth is None else truth)))
        if not K:
            return None
        closed = _closed(folder / "closed.tum", stamps[:K])
        truth, closed = (None if poses is None else poses[:K] for poses in (truth, closed))
        damage = tuple(map(str, filter(None, (*fault, *odometry_fault, *steps_fault, *truth_fault))))
        return cls(stamps[:K], estimate[:K], odometry[:K], truth, steps[:K], closed, damage)


def _closed(path: Path, stamps: FloatArray) -> FloatArray | None:
    """Return the closed trajectory at these scans; it may have more if other files are truncated.

    InputError if one is missing.
    """
    if not path.is_file():
        return None
    known, poses, cut = read_tum_so_far(path)
    count = len(stamps)
    if cut is not None and len(known) < count:
        raise cut
    if len(known) < count or np.abs(known[:count] - stamps).max() > SAME_STAMP:
        fault = f"has {len(poses)} poses for {count} scans" if len(known) < count else "is not of the scans of this run"
        raise InputError(f"{path}: {fault}; remove it, and the run counts as not closed")
    return poses


def carried_on(known: FloatArray, poses: FloatArray, stamps: FloatArray, motion: FloatArray) -> FloatArray:
    """Return poses (N, 3) at all ``stamps`` (N,) of a run, from ``poses`` (M, 3) at some of them (M,).

    After a known pose, and before the first one, the motion is that of ``motion`` (N, 3).
    """
    at = np.searchsorted(stamps, known - SAME_STAMP)
    last = np.maximum(np.searchsorted(at, np.arange(len(stamps)), side="right") - 1, 0)
    moved = relative_poses(motion[at[last]], motion)
    is_known = at[last] == np.arange(len(stamps))
    return np.where(is_known[:, None], poses[last], compose_poses(poses[last], moved))


def _has_lines(path: Path, count: int) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return sum(1 for _, _ in zip(file, range(count), strict=False)) == count


def pose_errors(poses: FloatArray, truth: FloatArray) -> FloatArray:
    """Estimate minus true pose, shape (K, 3): x, y in metres, heading in radians within [-pi, pi]."""
    errors = poses - truth
    errors[:, 2] = wrap_angles(errors[:, 2])
    return errors
