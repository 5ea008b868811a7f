"""What is said of many runs in a few numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import bootstrap

from slam.sweep.report.groups import Group

CONFIDENCE: Final = 0.95
_RESAMPLES: Final = 9999


@dataclass(frozen=True, slots=True)
class Difference:
    """One case less another, seed by seed: median, and the interval that bootstrapping gives it."""

    pairs: int
    """Seeds that both have."""
    median: float
    low: float
    high: float
    """Not a number, with ``low``, where there are fewer than two pairs."""
    lower: float
    """Share of the seeds for which the first of the two is lower."""


def difference(of: Group, less: Group) -> Difference | None:
    """Compared by seed, so that what a seed makes hard is no part of it; None where they have no seed in common."""
    other = dict(zip(less.seeds, less.values, strict=True))
    pairs = np.array([(a, other[s]) for s, a in zip(of.seeds, of.values, strict=True) if s in other])
    if not len(pairs):
        return None
    differences = pairs[:, 0] - pairs[:, 1]
    low, high = _interval(differences)
    return Difference(len(pairs), float(np.median(differences)), low, high, float(np.mean(differences < 0)))


def _interval(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[float, float]:
    """Of the median, by resampling; always the same resamples."""
    if len(values) < 2:
        return np.nan, np.nan
    found = bootstrap(
        (values,), np.median, n_resamples=_RESAMPLES, confidence_level=CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return float(found.low), float(found.high)
