"""``hopslam bench slam --stress``: errors on recorded logs that were made harder."""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Final

import numpy as np

from slam.bench.log_runs import find_logs
from slam.bench.stress.stress_run import StressRun, read_reference, run_variant
from slam.bench.stress.variant import Variant
from slam.config import SlamConfig
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal

WORKERS: Final = 2
LOGS: Final = ("fr079", "fr101", "belgioioso", "aces")
BACKWARDS: Final = ("fr079",)
"""Logs whose odometry has lost the sign of its backward motions."""
VARIANTS: Final = (
    "mend,every=1", "mend,every=5", "mend,every=10", "mend,every=20", "mend,every=40", "mend,every=5,blind=10",
    "mend,every=5,stale=0.3", "mend,every=20,beams=2,blind=5", "mend,beams=2", "mend,every=5,scale=0.02",
    "mend,slips=20", "mend,every=10,jitter=0.02", "mend,coarse=0.05", "scatter=0.4", "beams=2", "every=5",
    "every=10,beams=2",
)  # fmt: skip
BARS: Final = {
    "fr079": {
        "mend,every=1": 0.045, "mend,every=5": 0.054, "mend,every=10": 0.060, "mend,every=20": 0.071,
        "mend,every=40": 0.15, "mend,every=5,blind=10": 0.08, "mend,every=5,stale=0.3": 0.08,
        "mend,every=20,beams=2,blind=5": 0.15, "scatter=0.4": 0.08, "every=5": 0.08, "every=10,beams=2": 0.08,
    }
}  # fmt: skip
"""Metres that the method should not exceed, by log and variant."""


def stress_tables(
    names: Sequence[str], variants: Sequence[str], seeds: int, folder: Path, config: SlamConfig, console: Terminal
) -> list[ResultTable]:
    """Run variants of logs, each with these many seeds where something is drawn; the usual ones without a name."""
    asked = [Variant.parse(text) for text in variants]
    paths = find_logs(list(names) or LOGS, folder, console)
    jobs = [
        (name, variant, seed)
        for name in paths
        for variant in asked or usual_variants(name)
        for seed in range(1, (seeds if variant.random else 1) + 1)
    ]
    with ProcessPoolExecutor(WORKERS) as pool:
        futures = [(*job, pool.submit(run_variant, paths[job[0]], *job[1:], config)) for job in jobs]
        with console.progress() as bar:
            done = bar.track(futures, description="harder logs")
            runs = [(name, variant, future.result()) for name, variant, _, future in done]
    return [_table(name, paths[name], [run[1:] for run in runs if run[0] == name]) for name in paths]


def usual_variants(name: str) -> list[Variant]:
    """Variants of the table; only a log whose odometry asks for it is mended."""
    texts = VARIANTS if name in BACKWARDS else dict.fromkeys(text.removeprefix("mend,") for text in VARIANTS)
    return [Variant.parse(text) for text in texts]


def _table(name: str, path: Path, runs: Sequence[tuple[Variant, StressRun]]) -> ResultTable:
    measure = "ATE" if read_reference(path).relations is None else "mean error of the relations"
    columns = ("variant", "runs", "median\nm", "worst\nm", "bar\nm", "within", "odometry\nm", "scans", "lost",
        "odometry\nonly")  # fmt: skip
    notes = (
        f"{measure[0].upper()}{measure[1:]}, carried to the times of the reference by the unspoilt odometry. Odometry: "
        "that of the variant alone, median. Lost, odometry only (the scan said nothing that could be trusted): scans, "
        "the most of any run."
    )
    groups: dict[Variant, list[StressRun]] = {}
    for variant, run in runs:
        groups.setdefault(variant, []).append(run)
    rows = [_row(variant, group, BARS.get(name, {}).get(str(variant))) for variant, group in groups.items()]
    return ResultTable(f"{name}, made harder", columns, rows, notes)


def _row(variant: Variant, runs: Sequence[StressRun], bar: float | None) -> tuple[str, ...]:
    errors = np.array([run.error for run in runs])
    within = () if bar is None else np.round(errors, 3) <= bar
    return (
        str(variant), str(len(runs)), f"{np.median(errors):.3f}", f"{errors.max():.3f}",
        "" if bar is None else f"{bar:.3f}", "" if bar is None else f"{np.sum(within)} of {len(runs)}",
        f"{np.median([run.odometry_error for run in runs]):.3f}", str(runs[0].scans),
        str(max(run.lost for run in runs)), str(max(run.odometry_only for run in runs)),
    )  # fmt: skip
