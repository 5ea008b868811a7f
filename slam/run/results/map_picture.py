"""``map.png``: what was mapped, from above, in the manner of Figs. 16 and 21."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from slam.pose import FloatArray
from slam.run.logs.tum import read_tum
from slam.run.results.files import whole_file

_TRAJECTORIES = (
    ("odometry.tum", "dead reckoning", "tab:red", "-"),
    ("groundtruth.tum", "truth", "black", "--"),
    ("trajectory.tum", "SLAM", "tab:green", "-"),
)
_MAX_POINTS = 200_000
"""More map points than this are thinned evenly for the picture: it shows no more."""


def draw_map(folder: Path, points: FloatArray, segment_ends: FloatArray, outlines: Sequence[FloatArray]) -> None:
    """Write ``map.png`` into a run folder that has at least one step.

    ``points`` (N, 2), ``segment_ends`` (M, 2, 2) and the true wall ``outlines`` are in metres, map frame; the
    trajectories are read from the folder.
    """
    trajectories = [
        (read_tum(folder / name)[1], label, colour, style)
        for name, label, colour, style in _TRAJECTORIES
        if (folder / name).is_file()
    ]
    low, high = _extent(points, [poses[:, :2] for poses, *_ in trajectories])
    figure = Figure(figsize=_size(high - low), dpi=130, layout="constrained")
    axes = figure.add_subplot()
    axes.add_collection(PolyCollection(list(outlines), facecolors="0.88", edgecolors="0.75", linewidths=0.5, zorder=0))
    _draw_points(axes, points)
    _draw_segments(axes, segment_ends)
    for poses, label, colour, style in trajectories:
        axes.plot(poses[:, 0], poses[:, 1], color=colour, linestyle=style, linewidth=1.2, label=label)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    columns = max(1, round(float(figure.get_figwidth()) / 2.2))
    figure.legend(loc="outside upper center", ncols=columns, fontsize="small", frameon=False)
    with whole_file(folder / "map.png") as draft:
        figure.savefig(draft)


def _draw_points(axes: Axes, points: FloatArray) -> None:
    thinned = points[:: len(points) // _MAX_POINTS + 1]
    axes.plot(*thinned.T, ",", color="tab:pink", alpha=0.5, zorder=1)
    axes.plot([], [], ".", color="tab:pink", label="map points")


def _draw_segments(axes: Axes, ends: FloatArray) -> None:
    """Segments with a square at each start and a circle at each end; fainter the more there are."""
    strength = min(1.0, (800 / max(len(ends), 1)) ** 0.5)
    axes.add_collection(LineCollection(list(ends), colors="black", linewidths=0.4 + 0.8 * strength, zorder=3))
    for end, marker, colour, label in ((0, "s", "tab:blue", "segment start"), (1, "o", "tab:red", "segment end")):
        shape = {"linestyle": "none", "marker": marker, "markeredgecolor": colour, "markerfacecolor": "none"}
        drawn = {"markersize": 1.0 + 3.0 * strength, "markeredgewidth": 0.6, "alpha": strength, "zorder": 2.0}
        axes.plot(*ends[:, end].T, **shape, **drawn)  # type: ignore[arg-type]  # matplotlib types no keyword dicts
        axes.plot([], [], **shape, label=label)  # type: ignore[arg-type]  # in full strength, for the legend


def _extent(points: FloatArray, paths: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner of what is drawn: all paths, and the points but for the farthest 0.2 %; with a margin."""
    bulk = np.percentile(points, [0.1, 99.9], axis=0) if len(points) else np.zeros((1, 2))
    corners = np.concatenate([bulk, *paths])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.02 * float((high - low).max()) + 0.2
    return low - margin, high + margin


def _size(extent: FloatArray) -> tuple[float, float]:
    """Inches: the longer side 14, the shorter in proportion but never less than 4."""
    width, height = 13.0 * extent / extent.max()
    return max(float(width), 4.0) + 1.0, max(float(height), 3.0) + 1.0
