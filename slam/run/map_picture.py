"""``map.png``: what was mapped, from above, in the manner of Figs. 16 and 21."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from slam.pose import FloatArray
from slam.run.tum import read_tum

_TRAJECTORIES = (
    ("odometry.tum", "dead reckoning", "tab:red", "-"),
    ("groundtruth.tum", "truth", "black", "--"),
    ("trajectory.tum", "SLAM", "tab:green", "-"),
)
_MAX_POINTS = 200_000
"""More map points than this are thinned evenly for the picture: it shows no more."""


def draw_map(folder: Path, points: FloatArray, segment_ends: FloatArray, outlines: Sequence[FloatArray]) -> Path:
    """Write ``map.png`` into a run folder, and return its path.

    ``points`` (N, 2), ``segment_ends`` (M, 2, 2) and the true wall ``outlines`` are in metres, map frame; the
    trajectories are read from the folder.
    """
    trajectories = [
        (read_tum(folder / name)[1], label, colour, style)
        for name, label, colour, style in _TRAJECTORIES
        if (folder / name).is_file()
    ]
    low, high = _extent([points, *(poses[:, :2] for poses, *_ in trajectories)])
    figure = Figure(figsize=_size(high - low), dpi=130, layout="constrained")
    axes = figure.add_subplot()
    axes.add_collection(PolyCollection(list(outlines), facecolors="0.85", edgecolors="0.7", linewidths=0.5))
    _draw_points_and_segments(axes, points, segment_ends)
    for poses, label, colour, style in trajectories:
        axes.plot(poses[:, 0], poses[:, 1], color=colour, linestyle=style, linewidth=1.2, label=label)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    figure.legend(loc="outside upper center", ncols=7, fontsize="small", frameon=False)
    path = folder / "map.png"
    figure.savefig(path)
    return path


def _draw_points_and_segments(axes: Axes, points: FloatArray, ends: FloatArray) -> None:
    """Points, then segments with a square at each start and a circle at each end; thinner the more there are."""
    thinned = points[:: len(points) // _MAX_POINTS + 1]
    axes.plot(*thinned.T, ".", color="tab:pink", markersize=1.0, alpha=0.4, rasterized=True, label="map points")
    weight = 1.0 if len(ends) < 1000 else 0.4
    axes.add_collection(LineCollection(list(ends), colors="black", linewidths=1.2 * weight))
    for end, marker, colour, label in ((0, "s", "tab:blue", "segment start"), (1, "o", "tab:orange", "segment end")):
        axes.plot(
            *ends[:, end].T, linestyle="none", marker=marker, markeredgecolor=colour, markerfacecolor="none",
            markeredgewidth=0.6 * weight, markersize=4 * weight, label=label,
        )  # fmt: skip


def _extent(clouds: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner of what is drawn, with a margin."""
    everything = np.concatenate(clouds)
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.02 * float((high - low).max()) + 0.2
    return low - margin, high + margin


def _size(extent: FloatArray) -> tuple[float, float]:
    """Inches: the longer side 14, the shorter in proportion but never less than 4."""
    width, height = 13.0 * extent / extent.max()
    return max(float(width), 4.0) + 1.0, max(float(height), 3.0) + 1.0
