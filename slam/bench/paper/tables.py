"""Tables of the measurements, compared with the numbers in the paper."""

from collections.abc import Sequence
from math import degrees

from slam.bench.paper import fig_3, fig_8, fig_10, fig_21
from slam.bench.paper.fig_3 import Fig3
from slam.bench.paper.fig_7 import Fig7Row
from slam.bench.paper.fig_8 import Fig8, HoughLines, lines_on_walls
from slam.bench.paper.fig_21 import Fig21
from slam.bench.paper.table_2 import PAPER_SECONDS, PAPER_SPEED_UP, POINTS, Table2Row
from slam.console.result_table import ResultTable


def table_2(rows: Sequence[Table2Row], count: int) -> ResultTable:
    """Make the table of times and speed-ups over psi; the paper's own are for 2280 points."""
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
        f"of eq. (7). Values: its singular values only. Sums: prefix sums of the entries of A^T A, compiled.{fewer}",
    )


def figure_3(result: Fig3) -> ResultTable:
    """Make the table of one scan from a known pose."""
    pose, scan, ranges = result.T_map_laser, result.scan, result.scan.ranges[result.scan.echoes]
    return ResultTable(
        "Fig. 3: the scan from (1 m, 1 m, 20 deg) in the map of Fig. 1",
        ("", "here", "in the paper"),
        [
            ("X, Y", f"{pose.x:.3f} m, {pose.y:.3f} m", f"{fig_3.X_K:g} m, {fig_3.Y_K:g} m"),
            ("phi", f"{degrees(result.phi):.2f} deg", f"{degrees(fig_3.PHI_K):g} deg"),
            ("beams N", f"{len(scan.ranges)}", "240 deg / 1.875 deg = 128"),
            ("angle from beam to beam", f"{degrees(scan.angle_increment):.3f} deg", "1.875 deg"),
            ("points", f"{len(ranges)}", ""),
            ("ranges", f"{ranges.min():.3f} to {ranges.max():.3f} m", "0.06 to 4 m"),
            (
                "largest distance of a point from the walls",
                f"{1e3 * result.point_errors.max():.0f} mm",
                "25 mm or 2.5 %",
            ),
            ("segments", f"{len(result.segments)}", ""),
            (
                "largest distance of a segment's middle from the walls",
                f"{1e3 * result.segment_errors.max():.0f} mm",
                "",
            ),
        ],
        "The paper tells the pose (section 2) and the sensor (Table 1) and draws the points; it prints no range and no "
        "number of segments. The walls are those of scenarios/paper_simulation.yaml, in the shape of Fig. 1, for which "
        "the paper gives no coordinates. phi is 0 where the sensor looks along Y, so the heading of hopslam, whose x "
        "axis points ahead, is phi + 90 deg. Noise of Table 1 as three standard deviations; segments with psi = 1.",
    )


def figure_7(rows: Sequence[Fig7Row], trials: int) -> ResultTable:
    """Make the table of scans in which hopping changes the segments."""
    most, most_mean = max(row.different for row in rows), max(row.different_mean for row in rows)
    return ResultTable(
        f"Fig. 7: over-hopping, {trials} scans with a short segment between two long ones",
        ("psi", "scans that differ", "tests a scan", "differ by sigma_3 / sqrt(l)"),
        [(f"{row.psi}", f"{row.different}", f"{row.tests:.1f}", f"{row.different_mean}") for row in rows],
        f"Fig. 7(a) has a large psi omit a segment. Here {_up_to(most, trials)} from those of psi = 0: sigma_3 cannot "
        "fall when a point is added, so a psi that is too large costs tests after its reverse hops, and nothing else. "
        "sigma_3 / sqrt(l), which is not the paper's test, can fall: with a threshold on that, "
        f"{_up_to(most_mean, trials)} (last column).",
    )


def _up_to(most: int, trials: int) -> str:
    return f"up to {most} of {trials} scans differ" if most else f"none of {trials} scans differs"


def figure_8(result: Fig8) -> ResultTable:
    """Make the table of Hough and hopping on one scan."""
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
        "found. In the paper Hough misses BC, and hopping finds all three. A line belongs to a wall if both ends of "
        "the wall are within 5 cm of it.",
    )  # fmt: skip


def figure_10() -> ResultTable:
    """Make the table of the force field."""
    peak, half = fig_10.peak(), fig_10.half_width()
    distances = (0.01, 0.05, 0.1, 0.2, 0.4)
    shares = [(f"{distance} m", f"{fig_10.force(distance) / fig_10.force(peak):.3f}") for distance in distances]
    return ResultTable(
        "Fig. 10: the force of eq. (24)",
        ("distance", "share of the largest force"),
        [(f"{peak:.4f} m (peak)", "1.000"), (f"{half:.4f} m", "0.500"), *shares],
        "gamma_f = epsilon = 1e-4 and kappa = 3. Points more than about 10 cm off pull weakly.",
    )


def figure_21(result: Fig21) -> ResultTable:
    """Make the table of the share of matching and map update, for each kernel of line extraction."""
    matching, whole, other = fig_21.PAPER_MATCHING_SECONDS, fig_21.PAPER_SECONDS, result.prediction
    rows = [
        (
            name, f"{result.extraction[kernel].sum() + other:.3g}", f"{result.matching.sum():.3g}",
            f"{result.total(kernel):.3g}", f"{100.0 * result.share(kernel):.1f} %",
        )
        for kernel, name in fig_21.KERNELS.items()
    ]  # fmt: skip
    share = f"{100.0 * matching / whole:.1f} %"
    rows.append(("in the paper", f"{whole - matching:.1f}", f"{matching:.0f}", f"{whole:.1f}", share))
    map_columns = "matching and\nmap update, s", "whole\ns", "share of matching\nand map"
    return ResultTable(
        "Fig. 21: the time of a run along the corridor",
        ("sigma_3 by", "lines and\nall else, s", *map_columns),
        rows,
        "Wall time of the method in scenarios/paper_corridor.yaml, which simulates the paper's corridor: "
        f"{len(result.matching)} of {result.scans} scans were mapped. All three methods find the same segments, so the "
        "matching was timed in one run, and each method extracted the lines of its scans again. Physics, files and "
        "drawing are not counted. The paper states only that map updating and localization took 1302 of 1453.2 s, "
        "rounded to 89 %. The share depends on the implementation of each part: theirs is MATLAB, ours is compiled "
        "matching with numpy's SVD or compiled sums. It grows during the drive, as the map does.",
    )


def _found(lines: HoughLines) -> str:
    counts = lines_on_walls(lines.rho, lines.theta)
    return ", ".join(f"{count} on {name}" for name, count in counts.items() if name != "none" or count)
