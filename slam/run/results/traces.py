"""Trajectories and step table of a run, read back from its folder."""

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
"""Seconds between two stamps of one scan, which files round to the microsecond."""


@dataclass(frozen=True, slots=True, eq=False)
class Traces:
    """K steps: those that every file of the run has, so that a run which was cut off can be read too."""

    stamps: FloatArray
    """(K,) seconds."""
    estimate: FloatArray
    """(K, 3): x, y (m), heading (rad) of ``T_map_base`` as SLAM has it ..."""
    odometry: FloatArray
    """... as dead reckoning has it ..."""
    truth: FloatArray | None
    """... and as it was, where that is known."""
    steps: NDArray[Any]
    """(K,) records, named as the columns of ``steps.csv``."""
    closed: FloatArray | None = None
    """(K, 3): ``T_map_base`` as it is known after the last loop was closed; None where none was, and where the run was
    cut off before."""
    damage: tuple[str, ...] = ()
    """A sentence for each file that is damaged; what comes after that in it, and in the others, is left out."""

    @property
    def final(self) -> FloatArray:
        """(K, 3): the best that is known of ``T_map_base``, with all that came later where loops were closed."""
        return self.estimate if self.closed is None else self.closed

    @property
    def local(self) -> FloatArray | None:
        """(K, 3): ``T_local_base``, as odometry and matching have it without any closed loop; None of an older run."""
        if "local_x" not in (self.steps.dtype.names or ()):
            return None
        return np.column_stack([self.steps[name] for name in ("local_x", "local_y", "local_theta")])

    @property
    def odometry_only(self) -> NDArray[np.bool_]:
        """True for a scan that was matched and said nothing that could be trusted, (K,).

        Its pose is odometry alone. A scan between two updates is none, nor is any of an older run, which did not write
        it down.
        """
        if "odometry_only" not in (self.steps.dtype.names or ()):
            return np.zeros(len(self.steps), np.bool_)
        return np.asarray((self.steps["odometry_only"] == 1) & (self.steps["mapped"] == 1))

    @property
    def volts(self) -> FloatArray:
        """(K,): voltage of the base's battery; nan where nobody knows."""
        if "battery" not in (self.steps.dtype.names or ()):
            return np.full(len(self.steps), np.nan)
        return np.asarray(self.steps["battery"])

    @property
    def jumps(self) -> NDArray[np.bool_]:
        """True for a scan at which a closure was taken over: pose and map changed as a whole, (K,)."""
        if "closure" not in (self.steps.dtype.names or ()):
            return np.zeros(len(self.steps), np.bool_)
        return np.asarray(self.steps["closure"] >= 0)

    @property
    def closures(self) -> dict[int, int] | None:
        """The submap whose closure was taken over, by the number of the scan; None of a run that does not tell."""
        if "closure" not in (self.steps.dtype.names or ()):
            return None
        return {int(k): int(self.steps["closure"][k]) for k in np.flatnonzero(self.jumps)}

    @classmethod
    def read(cls, folder: Path) -> Self | None:
        """The traces of a run folder, up to where one of its files is damaged; None when it has no step."""
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
    """The closed trajectory, which has a pose for each of these scans, and for more where other files are cut.

    InputError where it has not.
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
    """Poses (N, 3) at all ``stamps`` (N,) of a run, of which ``poses`` (M, 3) are known at some (M,), others are not.

    From a known pose to the next one they go on as those of ``motion`` (N, 3) do, and before the first one too.
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
    """Estimate minus truth, shape (K, 3): x, y in metres, heading in radians within [-pi, pi]."""
    errors = poses - truth
    errors[:, 2] = wrap_angles(errors[:, 2])
    return errors
