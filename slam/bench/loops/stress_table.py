"""Table of harder variants of logs, with and without loop closing."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from slam.bench.loops.both_ways import run_both_ways
from slam.bench.stress.stress_report import BELOW, stress_cases
from slam.bench.stress.stress_runs import StressCase, log_of_case, trajectory_error
from slam.bench.stress.variants import made_harder, with_chance
from slam.bench.worker_pool import run_in_workers
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.scoring.pose_errors import Trajectory

STRESSED: Final = ("fr079",)


class StressErrors(NamedTuple):
    """Errors of a run without loop closing, of one with it, and of its end, metres: of the relations, or else ATE."""

    unclosed: float
    live: float
    final: float


def stress_table(
    names: Sequence[str], folder: Path, variants: Sequence[str], seeds: int, config: SlamConfig, console: Terminal
) -> list[ResultTable]:
    """Run each variant of each log with ``seeds`` seeds; without names and variants, those of fr079."""
    cases = stress_cases(names or STRESSED, folder, variants, console)
    jobs = [(case, seed, config) for case in cases for seed in range(1, 1 + seeds)]
    runs = run_in_workers(run_stressed_both_ways, jobs, "logs made harder", console)
    found = {case: runs[k * seeds : (k + 1) * seeds] for k, case in enumerate(cases)}
    return [_table(found)] if found and seeds else []


def run_stressed_both_ways(case: StressCase, seed: int, config: SlamConfig) -> StressErrors:
    """Apply the variant to the log, run the method with loops and without, and score both."""
    log = log_of_case(case)
    harder = made_harder(log, with_chance(case.variant), seed)
    found = run_both_ways(harder, config)
    wheels = Trajectory(log.stamps, log.T_odom_base)
    return StressErrors(
        *(
            trajectory_error(Trajectory(harder.stamps, poses), wheels, case.log)
            for poses in (found.unclosed, found.live, found.final)
        )
    )


def _table(found: Mapping[StressCase, Sequence[StressErrors]]) -> ResultTable:
    columns = (
        "log", "variant", "never\nmedian, m", "worst", "live\nmedian, m", "worst", "final\nmedian, m", "worst",
        "final\nbelow 8 cm",
    )  # fmt: skip
    notes = (
        "Error: mean error of the relations, or the ATE for a log without relations; median and worst of the seeds. "
        "Never: without loop closing. Mended: the lost signs of backward motions are restored."
    )
    return ResultTable("Loops on logs made harder", columns, [_row(case, runs) for case, runs in found.items()], notes)


def _row(case: StressCase, runs: Sequence[StressErrors]) -> tuple[str, ...]:
    errors = np.array(runs)
    pairs = np.column_stack([np.median(errors, axis=0), errors.max(axis=0)]).ravel()
    return (
        case.log.name.split(".")[0] + (", mended" if case.restored else ""), case.variant or "as it is",
        *(f"{value:.3f}" for value in pairs), f"{(errors[:, 2] < BELOW).sum()} of {len(runs)}",
    )  # fmt: skip
