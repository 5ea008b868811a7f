"""The scores of a trajectory, as values and as a table."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from slam.console.result_table import ResultTable
from slam.errors import InputError
from slam.pose import FloatArray
from slam.run.scoring import pose_errors
from slam.run.scoring.pose_errors import PoseErrors, Trajectory
from slam.run.scoring.trajectories import Source, reference_of, trajectories_to_score

Unit = Literal["m", "frames"]


class Score(NamedTuple):
    """One score: its name, its errors, and the number of comparisons that were requested."""

    name: str
    errors: PoseErrors
    asked: int

    @property
    def metres(self) -> dict[str, float]:
        """Statistics of the position errors: mean, std, rmse, median and max, metres; nan for none."""
        return statistics(self.errors.metres)

    @property
    def radians(self) -> dict[str, float]:
        """Statistics of the heading errors, radians."""
        return statistics(self.errors.radians)


class Delta(NamedTuple):
    """Length of the pieces over which the relative error is computed."""

    size: float = 1.0
    unit: Unit = "m"


@dataclass(frozen=True, slots=True, repr=False)
class Evaluation:
    """The scores of a trajectory, in the order of the tables."""

    scores: tuple[Score, ...]

    def __getitem__(self, name: str) -> Score:
        """Return the score with that name; KeyError lists the names."""
        for score in self.scores:
            if score.name == name:
                return score
        raise KeyError(f"no score {name!r}; there are {', '.join(score.name for score in self.scores)}")

    def as_dict(self) -> dict[str, Any]:
        """Return an object for each score, by its name; metres and radians, None if nothing was compared."""
        return {
            score.name: {
                "metres": score.metres if len(score.errors.metres) else None,
                "radians": score.radians if len(score.errors.radians) else None,
                "used": len(score.errors.metres),
                "of": score.asked,
            }
            for score in self.scores
        }

    def table(self) -> ResultTable:
        """Make a row for the translation of each score, and one for its rotation."""
        columns, rows = ("mean", "std", "rmse", "median", "max"), list[Sequence[str]]()
        for score in self.scores:
            used = f"{len(score.errors.metres)} of {score.asked}"
            for unit, values in (("m", score.metres), ("deg", statistics(np.degrees(score.errors.radians)))):
                rows.append((f"{score.name} [{unit}]", *(f"{values[column]:.4f}" for column in columns), used))
        return ResultTable("", ("", *columns, "used"), rows)

    def __repr__(self) -> str:
        scores = (f"{score.name} {score.metres['rmse']:.4f} m rmse" for score in self.scores)
        return f"Evaluation({'; '.join(scores)})"

    def _repr_html_(self) -> str:
        return self.table().html()


def evaluate(
    estimate: Source, reference: Source | None = None, *, relations: str | Path | None = None, delta: float = 1.0,
    delta_unit: Unit = "m", align: bool = True, max_gap: float = 1.0,
) -> Evaluation:  # fmt: skip
    """Score a trajectory against a reference, by absolute and relative error, or against known relative poses.

    ``relations`` is the file of the relative poses.

    A run folder has two trajectories, that estimated during the run and the final one with its loops closed; its
    default reference is its own true trajectory. The relative error is computed over pieces of ``delta`` metres of the
    true path, or of ``delta`` ``frames``. With ``align`` both are aligned rigidly before the absolute error; poses are
    interpolated if the nearest is within ``max_gap`` seconds. InputError if there is no reference, and if the two do
    not overlap in time.
    """
    if delta_unit not in ("m", "frames") or not delta > 0.0:
        raise InputError(f"delta {delta:g} {delta_unit}: give more than 0, in m or frames")
    if delta_unit == "frames" and delta < 1.0:
        raise InputError(f"delta {delta:g}: the next pose is 1 frame away; give 1 or more")
    scores: list[Score] = []
    for name, trajectory in trajectories_to_score(estimate).items():
        own: list[Score] = []
        if reference is not None or relations is None:
            true = reference_of(estimate, reference)
            own.extend(against_reference(trajectory, true, Delta(delta, delta_unit), align, max_gap))
        if relations is not None:
            own.append(against_relations(trajectory, Path(relations), max_gap))
        scores += [score._replace(name=name + score.name) for score in own]
    return Evaluation(tuple(scores))


def against_reference(
    estimate: Trajectory, reference: Trajectory, delta: Delta, align: bool, gap: float
) -> tuple[Score, Score]:
    """Compute ATE and RPE at the stamps of the reference that the estimate covers; InputError for fewer than 3."""
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
    """Compute the metric of Kuemmerle et al.; InputError if the estimate covers no relation."""
    relations = pose_errors.read_relations(path)
    errors = pose_errors.relation_errors(relations, *estimate, gap)
    if not len(errors.metres):
        raise InputError(f"{path}: none of its {len(relations)} relations lies in the time of the trajectory")
    return Score("relations", errors, len(relations))


def statistics(errors: FloatArray) -> dict[str, float]:
    """Return mean, standard deviation of all (not of a sample), root mean square, median and maximum; nan for none."""
    if not len(errors):
        return dict.fromkeys(("mean", "std", "rmse", "median", "max"), float("nan"))
    return {
        "mean": float(errors.mean()),
        "std": float(errors.std()),
        "rmse": float(np.sqrt(np.mean(errors**2))),
        "median": float(np.median(errors)),
        "max": float(errors.max()),
    }
