"""Tables of a sweep's report: summaries of the cases, and their differences seed by seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import bootstrap

from slam.console.result_table import ResultTable
from slam.pose import FloatArray
from slam.sweep.report.groups import RunGroup, group_by_name

_CONFIDENCE: Final = 0.95
_RESAMPLES: Final = 9999


@dataclass(frozen=True, slots=True)
class PairedDifference:
    """Difference of one case from another, seed by seed: its median, with a bootstrap interval."""

    pairs: int
    """Number of seeds that both have."""
    median: float
    low: float
    high: float
    """NaN, with ``low``, where there are fewer than two pairs."""
    lower: float
    """Share of the seeds for which the first case is lower."""


def tables(groups: list[RunGroup], metric: str) -> list[ResultTable]:
    """Tables of each scenario or log: a row a case, and each case compared with the first."""
    made = [
        table
        for name, (first, *others) in group_by_name(groups).items()
        for table in (_summary(f"{name}: {metric}", [first, *others]), _comparisons(f"{name}: {metric}", first, others))
    ]
    return [table for table in made if table.rows]


def paired_difference(group: RunGroup, baseline: RunGroup) -> PairedDifference | None:
    """Compare two cases seed by seed, so that hard seeds do not count; None where they have no seed in common."""
    other = dict(zip(baseline.seeds, baseline.values, strict=True))
    pairs = np.array([(a, other[s]) for s, a in zip(group.seeds, group.values, strict=True) if s in other])
    if not len(pairs):
        return None
    differences = pairs[:, 0] - pairs[:, 1]
    low, high = _interval(differences)
    return PairedDifference(len(pairs), float(np.median(differences)), low, high, float(np.mean(differences < 0)))


def _summary(title: str, groups: list[RunGroup]) -> ResultTable:
    rows = [
        [group.label, str(group.runs), str(len(group.failures)), str(group.collided), *_spread_cells(group)]
        for group in groups
    ]
    columns = ("case", "runs", "failed", "collided", "median", "p5", "p95", "worst")
    return ResultTable(title, columns, rows)


def _comparisons(title: str, first: RunGroup, others: list[RunGroup]) -> ResultTable:
    rows = [[other.label, *_difference_cells(paired_difference(other, first))] for other in others]
    columns = ("case", "pairs", "median", "95 % interval", "lower in")
    notes = "Difference seed by seed; the interval is that of its median, from a bootstrap of the seeds."
    return ResultTable(f"{title} less that of {first.label}", columns, rows, notes)


def _spread_cells(group: RunGroup) -> Iterator[str]:
    if not group.values:
        yield from ("-",) * 4
        return
    values = group.array
    low, high = np.percentile(values, [5, 95])
    yield f"{np.median(values):.3g}"
    yield f"{low:.3g}"
    yield f"{high:.3g}"
    yield f"{values.max():.3g}"


def _difference_cells(found: PairedDifference | None) -> Iterator[str]:
    if found is None:
        yield from ("0", "-", "-", "-")
        return
    yield str(found.pairs)
    yield f"{found.median:+.3g}"
    yield f"{found.low:+.3g} to {found.high:+.3g}" if found.pairs > 1 else "-"
    yield f"{100 * found.lower:.0f} %"


def _interval(values: FloatArray) -> tuple[float, float]:
    """Confidence interval of the median, always from the same resamples."""
    if len(values) < 2:
        return np.nan, np.nan
    found = bootstrap(
        (values,), np.median, n_resamples=_RESAMPLES, confidence_level=_CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return float(found.low), float(found.high)
