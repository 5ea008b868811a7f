"""A picture of one scan with its segments, in the manner of Figs. 8(d) and 15."""

from __future__ import annotations

from pathlib import Path

from matplotlib import colormaps
from matplotlib.figure import Figure

from slam.lines.segments import Segments
from slam.pose import FloatArray


def draw_scan(path: Path, points: FloatArray, segments: Segments, title: str) -> None:
    """Points (N, 2), metres, sensor frame, in the colours of their segments, grey where they have none; a square at the
    start of each segment and a circle at its end, a cross where the sensor is."""
    figure = Figure(figsize=(9, 9), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*points.T, ".", color="0.75", markersize=3)
    axes.plot(0.0, 0.0, "+", color="black", markersize=10)
    colours = colormaps["tab20"].colors  # type: ignore[attr-defined]  # of a listed colour map
    for m in range(len(segments)):
        colour = colours[2 * m % 20 + m // 10 % 2]
        start, end = segments.start[m], segments.end[m]
        axes.plot(*points[segments.first[m] : segments.last[m] + 1].T, ".", color=colour, markersize=4)
        axes.plot([start[0], end[0]], [start[1], end[1]], color=colour, linewidth=1.2)
        axes.plot(*start, "s", color=colour, markerfacecolor="none", markersize=8)
        axes.plot(*end, "o", color=colour, markerfacecolor="none", markersize=8)
    axes.set(title=title, xlabel="x [m]", ylabel="y [m]", aspect="equal")
    figure.savefig(path)
