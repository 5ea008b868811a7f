"""Table 2: time and speed-up of hopping over 2280 nearly collinear points.

It compares three ways to compute sigma_3, and the speed-up predicted by eqs. (13) and (14).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from slam.bench.stopwatch import seconds
from slam.lines.hopping import hop_by_svd, sigma_3, sigma_3_full
from slam.lines.prefix_sums import runs_and_lines
from slam.pose import FloatArray

POINTS: Final = 2280
"""Three scans of 760."""
PSI: Final = tuple(range(7))
PAPER_SECONDS: Final = (28.36, 14.90, 10.01, 7.68, 6.08, 5.09, 5.25)
PAPER_SPEED_UP: Final = (1.00, 1.90, 2.83, 3.68, 4.66, 5.56, 5.40)
SIGMA_TH: Final = 25.0 / 1024
NOISE: Final = 0.0003
"""Noise of the points, metres. With 0.5 mm or more, sigma_3 of all 2280 points is above SIGMA_TH, and they are split
into several segments."""
KERNELS: Final[dict[str, Callable[[FloatArray, int], object]]] = {
    "full_u": lambda points, psi: hop_by_svd(points, SIGMA_TH, psi, sigma_3_full),
    "values": lambda points, psi: hop_by_svd(points, SIGMA_TH, psi),
    "prefix_sums": lambda points, psi: runs_and_lines(points, SIGMA_TH, psi, 4, np.inf),
}
ROUNDS: Final = {"full_u": 2, "values": 10, "prefix_sums": 200}
_STEP: Final = 0.002
"""Share of the work between two reports of progress; reporting is not timed."""


@dataclass(frozen=True, slots=True)
class Table2Row:
    """Result of one hopping factor; times in seconds."""

    psi: int
    tests: int
    full_u: float
    """Time with the whole SVD of eq. (7), including the l x l matrix U."""
    values: float
    """Time with the singular values only."""
    prefix_sums: float
    """Time with prefix sums, compiled."""
    predicted: float
    """Speed-up by eqs. (13) and (14)."""


def wall(count: int, seed: int = 0) -> FloatArray:
    """Make points (count, 2) along 4 m of a wall 1 m in front of the sensor, with NOISE; metres."""
    off = np.random.default_rng(seed).normal(0.0, NOISE, count)
    return np.column_stack([1.0 + off, np.linspace(-2.0, 2.0, count)])


def tested_lengths(points: FloatArray, sigma_Th: float, psi: int) -> list[int]:
    """Return the numbers of points of which hopping computes sigma_3, test by test."""
    counts = []

    def counted(tested: FloatArray) -> float:
        counts.append(len(tested))
        return sigma_3(tested)

    hop_by_svd(points, sigma_Th, psi, counted)
    return counts


def measure(count: int = POINTS, advance: Callable[[float], object] = lambda share: None) -> list[Table2Row]:
    """Measure the rows of the table.

    Every time is the best of some rounds over all psi, so that other load does not slow a single row. With 2280 points
    this takes minutes; ``advance`` gets the share that is done.
    """
    points = wall(count)
    times = {name: np.full(len(PSI), np.inf) for name in KERNELS}
    for name, kernel in (KERNELS | {"full_u": _watched(points, advance)}).items():
        for _ in range(ROUNDS[name]):
            for psi in PSI:
                times[name][psi] = min(times[name][psi], seconds(partial(kernel, points, psi)))
    return [
        Table2Row(
            psi=psi,
            tests=len(tested_lengths(points, SIGMA_TH, psi)),
            predicted=predicted_speed_up(count, psi),
            **{name: float(best[psi]) for name, best in times.items()},
        )
        for psi in PSI
    ]


def _watched(points: FloatArray, advance: Callable[[float], object]) -> Callable[[FloatArray, int], object]:
    """Return the kernel with the full U, nearly all of the work, with its progress.

    U of l points has l x l entries.
    """
    whole = ROUNDS["full_u"] * sum(l * l for psi in PSI for l in tested_lengths(points, SIGMA_TH, psi))
    unreported = 0.0

    def measured(tested: FloatArray) -> float:
        nonlocal unreported
        unreported += len(tested) ** 2 / whole
        if unreported > _STEP:
            advance(unreported)
            unreported = 0.0
        return sigma_3_full(tested)

    return lambda points, psi: hop_by_svd(points, SIGMA_TH, psi, measured)


def hops(n: int, psi: int) -> tuple[int, int]:
    """Return (h_major, h_total) of a segment of n points, eq. (14): the long hops, and all hops."""
    h_major, h_minor = divmod(n - 1, psi + 1)
    return h_major, h_major + h_minor


def predicted_speed_up(n: int, psi: int, t: Callable[[int], float] = float) -> float:
    """Return the speed-up by eq. (13): the time of tests point by point, divided by that of tests with hops of psi.

    ``t`` is the time of a test as a function of the number of points, by default proportional to it, as for the
    singular values.

    The last sum is taken as printed: it counts short hops by their number, not by the points that they test.
    """
    h_major, h_total = hops(n, psi)
    every_point = sum(t(j) for j in range(1, n))
    long_hops = sum(t(1 + (j - 1) * (psi + 1)) for j in range(1, h_major + 1))
    short_hops = sum(t(j) for j in range(h_major + 1, h_total + 1))
    return every_point / (long_hops + short_hops)
