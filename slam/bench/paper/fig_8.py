"""Fig. 8: one scan of three segments AB, BC and CD; a Hough transform beside hopping with psi = 5."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.bench.floor_plans import cast_beams
from slam.bench.paper.fig_3 import draw_segments, upright
from slam.bench.stopwatch import median_seconds
from slam.config import HoppingConfig
from slam.lidars import URG04LX
from slam.lines.hopping import segments_by_hopping
from slam.lines.segments import Segments
from slam.named_code import import_optional
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.scan import LaserScan

PAPER_HOUGH_SECONDS: Final = 0.15742
PAPER_HOPPING_SECONDS: Final = 0.0806
WALLS: Final = {
    "AB": np.array([[1.60, 1.60], [1.60, 0.20]]),
    "BC": np.array([[1.60, 0.20], [1.35, -0.10]]),
    "CD": np.array([[1.35, -0.10], [1.35, -1.50]]),
}
"""Ends of the walls, metres, sensor frame. The paper gives no coordinates; these have the shape of its Fig. 8."""
NOISE: Final = 0.003
"""Standard deviation of the ranges, metres."""
_HOPPING: Final = {"psi": 5, "L_Th": 11}
"""Settings of the paper: psi = 5, and the smallest L_Th that the paper allows for it."""
_NEAR: Final = 0.05
"""A line belongs to a wall if both ends of the wall are nearer to it than this, metres."""
_CELL: Final = 0.01
"""Side of a pixel of the Hough transform's image, metres."""
_ANGLES: Final = np.radians(np.arange(-90.0, 90.0, 1.0))
_NEIGHBOURS: Final = {"min_distance": 1, "min_angle": 1}
"""Cells within which only the larger of two peaks is kept. A larger number finds fewer duplicates, and fewer true
lines."""


@dataclass(frozen=True, slots=True, eq=False)
class HoughLines:
    """Lines x cos(theta) + y sin(theta) = rho in the frame of the points, and the accumulator they were found in."""

    rho: FloatArray  # (M,) metres
    theta: FloatArray  # (M,) radians
    share: float
    """Peaks have at least this share of the most votes."""
    votes: FloatArray  # (D, A)
    peak_distances: FloatArray  # (M,) metres: the lines' rho in the accumulator
    distances: FloatArray  # (D,) metres from the corner of the image
    angles: FloatArray  # (A,) radians


@dataclass(frozen=True, slots=True, eq=False)
class Fig8:
    """Lines and segments that the two methods found, and their times in seconds."""

    scan: LaserScan
    hough: HoughLines
    hough_seconds: float
    lowered: HoughLines
    """Hough lines with the threshold lowered until BC is found; ``share`` is that threshold."""
    segments: Segments
    svd_seconds: float
    prefix_sums_seconds: float


def three_walls(seed: int = 0) -> LaserScan:
    """Make the scan; beams that pass beside the walls have no echo."""
    lidar = URG04LX.lidar
    ranges, _ = cast_beams(np.array([wall[::-1] for wall in WALLS.values()]), Pose2D(), lidar.angles)
    ranges += np.random.default_rng(seed).normal(0.0, NOISE, lidar.beams)
    ranges = np.round(ranges / URG04LX.resolution) * URG04LX.resolution
    return LaserScan(0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, ranges)


def hough_lines(points: FloatArray, share: float = 0.5) -> HoughLines:
    """Find lines through points (N, 2), metres, with ``share`` of the most votes of scikit-image's Hough transform."""
    transform = import_optional("skimage.transform", "bench")
    reach = np.abs(points).max(initial=_CELL)
    cells = np.floor((points + reach) / _CELL).astype(np.int64)
    picture = np.zeros(cells.max(axis=0, initial=0)[::-1] + 1, np.uint8)
    picture[cells[:, 1], cells[:, 0]] = 1
    votes, angles, distances = transform.hough_line(picture, theta=_ANGLES)
    _, theta, pixels = transform.hough_line_peaks(
        votes, angles, distances, threshold=share * votes.max(), num_peaks=np.inf, **_NEIGHBOURS
    )
    corner = 0.5 * _CELL - reach  # x and y of the middle of the first pixel
    rho = _CELL * pixels + corner * (np.cos(theta) + np.sin(theta))
    return HoughLines(rho, theta, share, votes.astype(np.float64), _CELL * pixels, _CELL * distances, angles)


def measure(repeats: int = 20) -> Fig8:
    """Run both methods on the scan."""
    scan = three_walls()
    points = scan.points()
    svd, sums = (HoppingConfig.model_validate({**_HOPPING, "kernel": kernel}) for kernel in ("svd", "prefix_sums"))
    return Fig8(
        scan=scan,
        hough=hough_lines(points),
        hough_seconds=median_seconds(partial(hough_lines, points), repeats),
        lowered=_lowered_until_bc(points),
        segments=segments_by_hopping(points, svd),
        svd_seconds=median_seconds(partial(segments_by_hopping, points, svd), repeats),
        prefix_sums_seconds=median_seconds(partial(segments_by_hopping, points, sums), 10 * repeats),
    )


def lines_on_walls(rho: FloatArray, theta: FloatArray) -> dict[str, int]:
    """Count the lines that lie along each wall, and along none of them ("none")."""
    normals = unit_vectors(theta)
    on = {name: (np.abs(ends @ normals.T - rho) < _NEAR).all(axis=0) for name, ends in WALLS.items()}
    none = ~np.any(list(on.values()), axis=0)
    return {name: int(found.sum()) for name, found in (on | {"none": none}).items()}


def _lowered_until_bc(points: FloatArray) -> HoughLines:
    for share in np.arange(0.5, 0.0, -0.02):
        lines = hough_lines(points, float(share))
        if lines_on_walls(lines.rho, lines.theta)["BC"]:
            break
    return lines


def draw(result: Fig8, path: Path) -> None:
    """Draw the four panels of the paper's figure."""
    figure = Figure(figsize=(14, 7.5), dpi=110, layout="constrained")
    (scan, space), (found, ours) = figure.subplots(2, 2)
    _draw_scan(scan, result, "(a) the scan", strong=True)
    _draw_space(space, result.hough)
    for panel in (found, ours):
        _draw_scan(panel, result, "", strong=False)
    counts = lines_on_walls(result.hough.rho, result.hough.theta)
    for rho, theta in zip(result.hough.rho, result.hough.theta, strict=True):
        foot, along = rho * np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
        found.axline(tuple(upright(foot)), tuple(upright(foot + along)), color=PAPER.odometry, linewidth=0.8)
    found.set_title("(c) Hough: " + ", ".join(f"{count} on {name}" for name, count in counts.items()))
    draw_segments(ours, result.segments, PAPER.odometry, (PAPER.slam, PAPER.slam), 1.5)
    ours.set_title(f"(d) hopping SVD, psi = 5: {len(result.segments)} segments")
    save_figure(figure, path)


def _draw_scan(axes: Axes, result: Fig8, title: str, strong: bool) -> None:
    axes.plot(*upright(result.scan.points()).T, ".", color="black" if strong else "0.6", markersize=3)
    axes.set(title=title, xlabel="-y [m]", ylabel="x [m]", aspect="equal", xlim=(-1.8, 1.7), ylim=(0.9, 2.1))
    for name, ends in WALLS.items():
        x, y = upright(ends.mean(axis=0)).tolist()
        axes.annotate(name, (x, y + 0.1), color=PAPER.accent)


def _draw_space(axes: Axes, hough: HoughLines) -> None:
    extent = (np.degrees(hough.angles[0]), np.degrees(hough.angles[-1]), hough.distances[0], hough.distances[-1])
    axes.imshow(np.sqrt(hough.votes), origin="lower", extent=extent, aspect="auto", cmap="magma")
    axes.plot(np.degrees(hough.theta), hough.peak_distances, "s", color="white", markerfacecolor="none", markersize=7)
    axes.set(xlabel="theta [deg]", ylabel="rho from the corner [m]", xlim=(-60.0, 60.0), ylim=(0.0, None))
    axes.set_title("(b) Hough space, peaks in white squares")
