"""The method on one variant of a log, scored against the log's reference."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from slam.bench.log_runs import run_over
from slam.bench.stress.carried_poses import carried_poses
from slam.bench.stress.variant import Variant
from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.logs import Log, read_log
from slam.files.tum import read_tum
from slam.pose import FloatArray
from slam.run.scoring.pose_errors import InterpolatedPoses, absolute_error, read_relations, relation_errors_of


@dataclass(frozen=True, slots=True)
class StressRun:
    """What came out of one variant with one seed."""

    error: float
    """Metres: mean error of the relations where the log has such, else ATE ..."""
    odometry_error: float
    """... and that of the odometry which the method was given."""
    scans: int
    lost: int
    """Scans in which the robot was lost ..."""
    odometry_only: int
    """... or said nothing that could be trusted."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A log, and what is known of its way; ``stem.gt.tum`` and ``stem.relations.gz`` beside ``stem.log.gz``."""

    log: Log
    times: FloatArray
    """Of the true poses, (K,) ..."""
    truth: FloatArray
    """... which are these, (K, 3)."""
    relations: FloatArray | None

    def error(self, stamps: FloatArray, poses: FloatArray, odometry: FloatArray) -> float:
        """Error of a trajectory, metres; ``odometry`` (N, 3) at the log's stamps leads from scan to scan."""

        def carried(times: FloatArray) -> InterpolatedPoses:
            return carried_poses(times, stamps, poses, self.log.stamps, odometry)

        if self.relations is None:
            at = carried(self.times)
            return absolute_error(at.poses[at.known], self.truth[at.known])
        first, second = carried(self.relations[:, 0]), carried(self.relations[:, 1])
        return float(np.mean(relation_errors_of(self.relations, first, second).metres))


@lru_cache(maxsize=1)
def read_reference(path: Path) -> Reference:
    """The log at this path with its reference; InputError where there is none."""
    truth, relations = (path.with_name(path.name.split(".")[0] + end) for end in (".gt.tum", ".relations.gz"))
    if not truth.is_file():
        raise InputError(f"{path}: no {truth.name} beside it, so nothing tells how wrong a pose is")
    return Reference(read_log(path), *read_tum(truth), read_relations(relations) if relations.is_file() else None)


def run_variant(path: Path, variant: Variant, seed: int, config: SlamConfig) -> StressRun:
    """Run the method on the variant of the log at this path."""
    reference = read_reference(path)
    unspoilt = variant.unspoilt(reference.log, reference.times, reference.truth)
    log = variant.spoilt(unspoilt, seed)
    run = run_over(log, path.name, config)
    error, odometry_error = (
        reference.error(log.stamps, poses, unspoilt.T_odom_base) for poses in (run.poses, log.T_odom_base)
    )
    return StressRun(error, odometry_error, len(log), run.lost, run.odometry_only)
