"""The tables of a sweep's report."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from slam.console.result_table import ResultTable
from slam.sweep.report.groups import Group, by_name
from slam.sweep.report.statistics import Difference, difference


def tables(groups: list[Group], metric: str) -> list[ResultTable]:
    """For each scenario or log a row a case, and each case compared with the first."""
    made = [
        table
        for name, (first, *others) in by_name(groups).items()
        for table in (_summary(f"{name}: {metric}", [first, *others]), _comparisons(f"{name}: {metric}", first, others))
    ]
    return [table for table in made if table.rows]


def _summary(title: str, groups: list[Group]) -> ResultTable:
    rows = [
        [group.label, str(group.runs), str(len(group.failures)), str(group.collided), *_spread(group)]
        for group in groups
    ]
    columns = ("case", "runs", "failed", "collided", "median", "p5", "p95", "worst")
    return ResultTable(title, columns, rows)


def _comparisons(title: str, first: Group, others: list[Group]) -> ResultTable:
    rows = [[other.label, *_difference(difference(other, first))] for other in others]
    columns = ("case", "pairs", "median", "95 % interval", "lower in")
    notes = "Difference seed by seed; the interval is that of its median, from a bootstrap of the seeds."
    return ResultTable(f"{title} less that of {first.label}", columns, rows, notes)


def _spread(group: Group) -> Iterator[str]:
    if not group.values:
        yield from ("-",) * 4
        return
    values = group.array
    low, high = np.percentile(values, [5, 95])
    yield f"{np.median(values):.3g}"
    yield f"{low:.3g}"
    yield f"{high:.3g}"
    yield f"{values.max():.3g}"


def _difference(found: Difference | None) -> Iterator[str]:
    if found is None:
        yield from ("0", "-", "-", "-")
        return
    yield str(found.pairs)
    yield f"{found.median:+.3g}"
    yield f"{found.low:+.3g} to {found.high:+.3g}" if found.pairs > 1 else "-"
    yield f"{100 * found.lower:.0f} %"
