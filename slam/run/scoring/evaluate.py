"""The scores of a trajectory, to be shown as a table."""

from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from slam.errors import InputError
from slam.files.tum import read_tum
from slam.pose import FloatArray
from slam.run.results.run_record import RunRecord
from slam.run.scoring import pose_errors
from slam.run.scoring.pose_errors import PoseErrors, Trajectory

Unit = Literal["m", "frames"]


class Score(NamedTuple):
    """One measure: its name, its errors, and the number of comparisons that were asked for."""

    name: str
    errors: PoseErrors
    asked: int


class Delta(NamedTuple):
    """Length of the pieces over which the relative error is taken."""

    size: float = 1.0
    unit: Unit = "m"


def read_trajectory(path: Path) -> Trajectory:
    """Read the final trajectory of a run folder, or the poses of a TUM file; InputError for a path that is neither."""
    if path.is_dir():
        traces = RunRecord.open(path).traces
        return Trajectory(traces.stamps, traces.final)
    return Trajectory(*read_tum(path))


def trajectories_to_score(path: Path) -> dict[str, Trajectory]:
    """By what stands before the names of their scores: of a run folder the estimate as it was known on the way, and
    where its loops were closed what is known in the end; or the poses of a TUM file. InputError for what is neither."""
    if not path.is_dir():
        return {"": Trajectory(*read_tum(path))}
    traces = RunRecord.open(path).traces
    known = {"": traces.estimate} if traces.closed is None else {"": traces.estimate, "closed: ": traces.closed}
    return {name: Trajectory(traces.stamps, poses) for name, poses in known.items()}


def reference_of(path: Path, given: Path | None) -> Path:
    """The given reference, or the truth of a run; InputError where there is none."""
    if given is not None:
        return given
    if (path / "groundtruth.tum").is_file():
        return path / "groundtruth.tum"
    raise InputError(f"{path}: knows no truth; give --reference FILE.tum or --relations FILE")


def against_reference(
    estimate: Trajectory, reference: Trajectory, delta: Delta, align: bool, gap: float
) -> tuple[Score, Score]:
    """ATE and RPE at the stamps of the reference that the estimate covers; InputError where these are fewer than 3."""
    at = pose_errors.poses_at(reference.stamps, *estimate, gap)
    poses, truth = at.poses[at.known], reference.poses[at.known]
    if len(poses) < 3:
        raise InputError(f"the two trajectories share {len(poses)} stamps; need 3, on one clock, within {gap:g} s")
    if delta.unit == "m":
        relative = pose_errors.errors_by_path(poses, truth, delta.size)
    else:
        relative = pose_errors.errors_by_frames(poses, truth, round(delta.size))
    absolute = pose_errors.absolute_errors(poses, truth, align)
    ate = Score("ATE, aligned" if align else "ATE", absolute, len(reference.stamps))
    return ate, Score(f"RPE over {delta.size:g} {delta.unit}", relative, len(relative.metres))


def against_relations(estimate: Trajectory, path: Path, gap: float) -> Score:
    """The metric of Kuemmerle et al.; InputError where the estimate covers no relation."""
    relations = pose_errors.read_relations(path)
    errors = pose_errors.relation_errors(relations, *estimate, gap)
    if not len(errors.metres):
        raise InputError(f"{path}: none of its {len(relations)} relations lies in the time of the trajectory")
    return Score("relations", errors, len(relations))


def statistics(errors: FloatArray) -> dict[str, float]:
    """Mean, standard deviation of all (not of a sample), root mean square, median and maximum; nan of none."""
    if not len(errors):
        return dict.fromkeys(("mean", "std", "rmse", "median", "max"), float("nan"))
    return {
        "mean": float(errors.mean()),
        "std": float(errors.std()),
        "rmse": float(np.sqrt(np.mean(errors**2))),
        "median": float(np.median(errors)),
        "max": float(errors.max()),
    }
