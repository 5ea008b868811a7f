"""Runs of the method on harder variants of logs, and their errors."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from slam.bench.log_runs import run_on
from slam.bench.stress.odometry_steps import with_signs
from slam.bench.stress.variants import made_harder, with_chance
from slam.config import SlamConfig
from slam.files.logs import Log, read_log
from slam.files.tum import read_tum
from slam.run.scoring.pose_errors import (
    Trajectory,
    absolute_error,
    carried_poses,
    errors_between,
    read_relations,
)


class StressCase(NamedTuple):
    """A log and the variant that makes it harder."""

    log: Path
    restored: bool
    """True to restore the odometry's lost signs first, by the reference."""
    variant: str


class StressRun(NamedTuple):
    """Result of the method on a variant of a log."""

    error: float
    """Error, metres: mean of the relations if the log has them, else the ATE."""
    odometry_error: float
    """The same error of the odometry alone."""
    scans: int
    lost: int
    odometry_only: int


def run_stressed(case: StressCase, seed: int, config: SlamConfig) -> StressRun:
    """Apply the variant to the log, run the method on it, and score the result."""
    log = log_of_case(case)
    run = run_on(made_harder(log, with_chance(case.variant), seed), case.log.name, config)
    wheels = Trajectory(log.stamps, log.T_odom_base)
    error, odometry_error = (
        trajectory_error(Trajectory(run.log.stamps, poses), wheels, case.log) for poses in (run.poses, run.odometry)
    )
    return StressRun(error, odometry_error, len(run.poses), run.lost, run.odometry_only)


def reference_of(log: Path, kind: str = "gt.tum") -> Path:
    """Return the path of a log's reference: ``gt.tum`` or ``relations.gz`` with the log's name."""
    return log.with_name(f"{log.name.split('.')[0]}.{kind}")


def log_of_case(case: StressCase) -> Log:
    """Read the log of a case, with its lost signs restored if the case asks for that."""
    return _log(case.log, case.restored)


@lru_cache(maxsize=2)
def _log(path: Path, restored: bool) -> Log:
    log = read_log(path)
    if not restored:
        return log
    reference = Trajectory(*read_tum(reference_of(path)))
    return replace(log, T_odom_base=with_signs(log.stamps, log.T_odom_base, reference))


def trajectory_error(trajectory: Trajectory, wheels: Trajectory, log: Path) -> float:
    """Return the error at the times of the log's relations, if it has any, or else at those of its reference."""
    if (path := reference_of(log, "relations.gz")).is_file():
        relations = read_relations(path)
        first, second = (carried_poses(relations[:, column], trajectory, wheels) for column in (0, 1))
        return float(np.mean(errors_between(relations, first, second).metres))
    times, truth = read_tum(reference_of(log))
    found = carried_poses(times, trajectory, wheels)
    return absolute_error(found.poses[found.known], truth[found.known])
