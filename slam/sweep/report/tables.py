"""Tables of a sweep's report: summaries of the cases, and their differences seed by seed."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import bootstrap

from slam.console.result_table import ResultTable
from slam.pose import FloatArray
from slam.run.results.metric_table import more_is_better
from slam.sweep.report.groups import RunGroup, group_by_name

_CONFIDENCE: Final = 0.95
_RESAMPLES: Final = 9999


@dataclass(frozen=True, slots=True)
class PairedDifference:
    """Difference between two cases, seed by seed: its median, with a bootstrap interval."""

    pairs: int
    """Number of seeds that both have."""
    median: float
    low: float
    high: float
    """nan, like ``low``, for fewer than two pairs."""
    lower: float
    """Share of the seeds for which the first case is lower."""


def tables(groups: list[RunGroup], metric: str) -> list[ResultTable]:
    """Make tables of each scenario or log: a row per case, and each case compared with the first."""
    made = [
        table
        for name, (first, *others) in group_by_name(groups).items()
        for table in (_summary(name, metric, [first, *others]), _comparisons(f"{name}: {metric}", first, others))
    ]
    return [table for table in made if table.rows]


def paired_difference(group: RunGroup, baseline: RunGroup) -> PairedDifference | None:
    """Compare two cases seed by seed, so that hard seeds cancel; None without a common seed."""
    other = dict(zip(baseline.seeds, baseline.values, strict=True))
    pairs = np.array([(a, other[s]) for s, a in zip(group.seeds, group.values, strict=True) if s in other])
    if not len(pairs):
        return None
    differences = pairs[:, 0] - pairs[:, 1]
    low, high = _interval(differences)
    return PairedDifference(len(pairs), float(np.median(differences)), low, high, float(np.mean(differences < 0)))


def _summary(name: str, metric: str, groups: list[RunGroup]) -> ResultTable:
    rows = [
        [group.label, str(group.runs), str(len(group.failures)), str(group.collided), *_spread_cells(group, metric)]
        for group in groups
    ]
    columns = ("case", "runs", "failed", "collided", "median", "p5", "p95", "worst")
    return ResultTable(f"{name}: {metric}", columns, rows)


def _comparisons(title: str, first: RunGroup, others: list[RunGroup]) -> ResultTable:
    rows = [[other.label, *_difference_cells(paired_difference(other, first))] for other in others]
    columns = ("case", "pairs", "median", "95 % interval", "lower in")
    notes = "Difference seed by seed; the interval is that of its median, from a bootstrap of the seeds."
    return ResultTable(f"{title} less that of {first.label}", columns, rows, notes)


def _spread_cells(group: RunGroup, metric: str) -> list[str]:
    if not group.values:
        return ["-"] * 4
    low, high = np.percentile(group.values, [5, 95])
    worst = min(group.values) if more_is_better(metric) else max(group.values)
    return [f"{value:.3g}" for value in (np.median(group.values), low, high, worst)]


def _difference_cells(found: PairedDifference | None) -> tuple[str, str, str, str]:
    if found is None:
        return "0", "-", "-", "-"
    interval = f"{found.low:+.3g} to {found.high:+.3g}" if found.pairs > 1 else "-"
    return str(found.pairs), f"{found.median:+.3g}", interval, f"{100 * found.lower:.0f} %"


def _interval(values: FloatArray) -> tuple[float, float]:
    """Return the confidence interval of the median, from fixed resamples."""
    if len(values) < 2:
        return np.nan, np.nan
    found = bootstrap(
        (values,), np.median, n_resamples=_RESAMPLES, confidence_level=_CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return float(found.low), float(found.high)
