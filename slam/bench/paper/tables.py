"""What was measured beside what the paper printed."""

from __future__ import annotations

from collections.abc import Sequence

from slam.bench.paper import fig_8, fig_10
from slam.bench.paper.fig_7 import Fig7Row
from slam.bench.paper.fig_8 import Fig8, lines_on_walls
from slam.bench.paper.hough import HoughLines
from slam.bench.paper.table_2 import PAPER_SECONDS, PAPER_SPEED_UP, POINTS, Table2Row
from slam.console.result_table import ResultTable


def table_2(rows: Sequence[Table2Row], count: int) -> ResultTable:
    """Times and speed-ups over psi; the paper's own are of 2280 points."""
    first = rows[0]
    columns = (
        "psi", "tests", "full U\ns", "values\nms", "sums\nus", "full U", "values", "sums", "eq. 13", "paper\ns",
        "paper",
    )  # fmt: skip
    cells = [
        (
            f"{row.psi}", f"{row.tests}",
            f"{row.full_u:.3g}", f"{1e3 * row.values:.1f}", f"{1e6 * row.prefix_sums:.1f}",
            f"{first.full_u / row.full_u:.2f}", f"{first.values / row.values:.2f}",
            f"{first.prefix_sums / row.prefix_sums:.2f}", f"{row.predicted:.2f}", f"{paper_time:.2f}", f"{paper:.2f}",
        )
        for row, paper_time, paper in zip(rows, PAPER_SECONDS, PAPER_SPEED_UP, strict=True)
    ]  # fmt: skip
    fewer = "" if count == POINTS else f" Only {count} points were used here, the paper's numbers are of {POINTS}."
    return ResultTable(
        f"Table 2: hopping over {count} nearly collinear points",
        columns,
        cells,
        "Columns with a unit are times, best of some rounds on one thread, the others speed-ups. Full U: the whole SVD "
        "of eq. (7). Values: its singular values only. Sums: prefix sums of the entries of A^T A, compiled."
        f"{fewer}",
    )


def figure_7(rows: Sequence[Fig7Row], trials: int) -> ResultTable:
    """How often hopping changes a result."""
    return ResultTable(
        f"Fig. 7: over-hopping, {trials} scans with a short segment between two long ones",
        ("psi", "scans that differ", "tests a scan", "differ by sigma_3 / sqrt(l)"),
        [(f"{row.psi}", f"{row.different}", f"{row.tests:.1f}", f"{row.different_mean}") for row in rows],
        "sigma_3 cannot fall when a point is added, so no psi changes a segment, whatever Fig. 7(a) says: one that is "
        "too large costs tests after its reverse hops, and nothing else. A threshold on sigma_3 / sqrt(l) gives this "
        "up: the last column counts the scans that then differ.",
    )


def figure_8(result: Fig8) -> ResultTable:
    """Hough and hopping on one scan."""
    paper_ratio = fig_8.PAPER_HOUGH_SECONDS / fig_8.PAPER_HOPPING_SECONDS
    hopping = f"{len(result.segments)} segments"
    return ResultTable(
        "Fig. 8: three segments AB, BC, CD in one scan",
        ("method", "found", "time ms", "speed-up", "in the paper"),
        [
            ("Hough, half of the most votes", _found(result.hough), f"{1e3 * result.hough_seconds:.3f}", "1.0",
             "157.42 ms"),
            (f"Hough, {result.lowered.share:.2f} of the most votes", _found(result.lowered), "", "", ""),
            ("hopping SVD, psi = 5", hopping, f"{1e3 * result.svd_seconds:.3f}",
             f"{result.hough_seconds / result.svd_seconds:.1f}", f"80.6 ms ({paper_ratio:.2f})"),
            ("the same from prefix sums", hopping, f"{1e3 * result.prefix_sums_seconds:.3f}",
             f"{result.hough_seconds / result.prefix_sums_seconds:.0f}", ""),
        ],
        "Hough is scikit-image's, on pixels of 1 cm and steps of 1 degree. Its second row lowers the votes until BC is "
        "found. In the paper Hough misses BC, and hopping finds all three. A line counts for a wall when it passes "
        "both its ends nearer than 5 cm.",
    )  # fmt: skip


def figure_10() -> ResultTable:
    """The force field in numbers."""
    peak, half = fig_10.peak(), fig_10.half_width()
    shares = [(f"{distance} m", f"{_share(distance):.3f}") for distance in (0.01, 0.05, 0.1, 0.2, 0.4)]
    return ResultTable(
        "Fig. 10: the force of eq. (24)",
        ("distance", "share of the largest force"),
        [(f"{peak:.4f} m (peak)", "1.000"), (f"{half:.4f} m", "0.500"), *shares],
        "gamma_f = epsilon = 1e-4 and kappa = 3. Points more than about 10 cm off pull weakly.",
    )


def _share(distance: float) -> float:
    return fig_10.force(distance) / fig_10.force(fig_10.peak())


def _found(lines: HoughLines) -> str:
    counts = lines_on_walls(lines.rho, lines.theta)
    return ", ".join(f"{count} on {name}" for name, count in counts.items() if name != "none" or count)
