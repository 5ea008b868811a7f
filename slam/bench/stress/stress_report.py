"""``hopslam bench slam --stress``: errors on harder variants of recorded logs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from slam.bench.log_runs import LOGS
from slam.bench.stress.stress_runs import StressCase, StressRun, reference_of, run_stressed
from slam.bench.stress.variants import TINY_NOISE, with_chance
from slam.bench.worker_pool import run_in_workers
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal

LOST_SIGNS: Final = ("fr079",)
"""Logs whose wheel odometry has lost the sign of backward motions, a fault that no variant makes."""
DENSE_VARIANTS: Final = (
    "", "every=5", "every=10", "every=20", "every=40", "every=5,blind=10", "every=5,stale=0.3",
    "every=20,beams=2,blind=5", "beams=2", "every=5,scale=0.02", "every=5,slips=20", "every=10,jitter=0.05",
    "every=5,coarse=0.05", "every=5,scatter=0.4",
)  # fmt: skip
UNMENDED_VARIANTS: Final = ("scatter=0.4", "beams=2", "every=5", "every=10,beams=2")
"""Variants that are also run on logs with lost signs as they were recorded, without mending the signs."""
SPARSE_VARIANTS: Final = (
    "", "every=2", "beams=2", "blind=10", "stale=0.3", "scale=0.02", "slips=20", "jitter=0.05",
    "coarse=0.05", "scatter=0.4",
)  # fmt: skip
"""Variants for the other logs of the table, whose scans are a metre apart."""
TABLE_LOGS: Final = ("fr079", "fr101", "belgioioso", "aces")
COLUMNS: Final = (
    "log", "variant", "error\nm", "worst\nm", "below\n8 cm", "odometry\nm", "scans", "lost",
    "odometry\nonly",
)  # fmt: skip
BELOW: Final = 0.08
"""Error, metres, below which a run counts as good as on the original log."""


def stress_tables(
    names: Sequence[str], folder: Path, variants: Sequence[str], seeds: int, config: SlamConfig, console: Terminal
) -> list[ResultTable]:
    """Run each variant of each log with ``seeds`` seeds; without names and variants, those of the project's table."""
    cases = stress_cases(names, folder, variants, console)
    jobs = [(case, seed, config) for case in cases for seed in range(1, 1 + seeds)]
    runs = run_in_workers(run_stressed, jobs, "logs made harder", console)
    found = {case: runs[k * seeds : (k + 1) * seeds] for k, case in enumerate(cases)}
    return [_table(found)] if found else []


def stress_cases(names: Sequence[str], folder: Path, variants: Sequence[str], console: Terminal) -> list[StressCase]:
    """Return the requested cases whose log and reference exist; InputError for an invalid variant."""
    for variant in variants:
        with_chance(variant)
    cases: list[StressCase] = []
    for name in names or TABLE_LOGS:
        path = folder / LOGS.get(name, name)
        reference = reference_of(path)
        if not path.is_file() or not reference.is_file():
            console.print(f"{name}: no {reference if path.is_file() else path}; skipped")
            continue
        mend = name in LOST_SIGNS
        dense = mend or name not in TABLE_LOGS
        cases += [StressCase(path, mend, v) for v in variants or (DENSE_VARIANTS if dense else SPARSE_VARIANTS)]
        if mend:
            cases += [StressCase(path, False, v) for v in variants or UNMENDED_VARIANTS]
    return cases


def _table(found: Mapping[StressCase, Sequence[StressRun]]) -> ResultTable:
    notes = (
        "Error: mean error of the relations, or the ATE for a log without relations; median of the seeds. At "
        "times without a scan the estimate is continued by the original odometry. Mended: the lost signs of backward "
        f"motions are restored. A variant without random numbers has {TINY_NOISE} on its ranges. Below: runs with less "
        "than 8 cm."
    )
    return ResultTable("On logs made harder", COLUMNS, [_row(case, runs) for case, runs in found.items()], notes)


def _row(case: StressCase, runs: Sequence[StressRun]) -> tuple[str, ...]:
    errors = np.array([run.error for run in runs])
    return (
        case.log.name.split(".")[0] + (", mended" if case.restored else ""), case.variant or "as it is",
        f"{np.median(errors):.3f}", f"{errors.max():.3f}", f"{(errors < BELOW).sum()} of {len(runs)}",
        f"{np.median([run.odometry_error for run in runs]):.3f}", str(runs[0].scans),
        *(f"{np.median([getattr(run, name) for run in runs]):.0f}" for name in ("lost", "odometry_only")),
    )  # fmt: skip
