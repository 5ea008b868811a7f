"""A picture of one scan with its segments, in the style of Figs. 8(d) and 15."""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.lines.segments import Segments
from slam.pose import FloatArray
from slam.run.pictures.figure_style import PAPER, save_figure


def draw_scan(path: Path, points: FloatArray, segments: Segments, title: str) -> None:
    """Write the picture of a scan to a file; see ``scan_figure``."""
    save_figure(scan_figure(points, segments, title), path)


def scan_figure(points: FloatArray, segments: Segments | None, title: str, inches: float = 9.0) -> Figure:
    """Draw points (N, 2), metres, sensor frame, in the colours of their segments, grey without one.

    Three colours alternate, so that neighbours differ. A square is at the start of each segment, a circle at its end, a
    cross at the sensor.
    """
    figure = Figure(figsize=(inches, inches), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*points.T, ".", color="0.75" if segments is not None else PAPER.ink, markersize=3)
    axes.plot(0.0, 0.0, "+", color="black", markersize=10)
    if segments is not None:
        _draw_segments(axes, points, segments)
    axes.set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return figure


def _draw_segments(axes: Axes, points: FloatArray, segments: Segments) -> None:
    for m in range(len(segments)):
        colour, _ = PAPER.curve(m)
        start, end = segments.start[m], segments.end[m]
        axes.plot(*points[segments.first[m] : segments.last[m] + 1].T, ".", color=colour, markersize=4)
        axes.plot([start[0], end[0]], [start[1], end[1]], color=colour, linewidth=1.2)
        axes.plot(*start, "s", color=colour, markerfacecolor="none", markersize=8)
        axes.plot(*end, "o", color=colour, markerfacecolor="none", markersize=8)
