"""Figs. 15, 16 and 21 of the paper, from a run: □ where a segment starts, ○ where it ends, map points as pink +."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.pictures.figure_style import PAPER, figure_size
from slam.run.results.run_record import RunRecord

_PINK, _START, _END = "#e377c2", PAPER.slam, PAPER.odometry
_EVERY = 20_000
"""Number of points above which they are thinned: print shows no more."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanPoints:
    """Numbers and points of the scans that a run has mapped."""

    scans: list[int]
    points: list[FloatArray]
    """(N, 2) each: points, metres, sensor frame."""
    T_base_laser: Pose2D

    def placed(self, poses: FloatArray, before: int | None = None) -> FloatArray:
        """Return the points (N, 2) of all scans, or of those before the scan ``before``, for these ``poses`` (K, 3)."""
        parts = [
            (Pose2D(*poses[k]) @ self.T_base_laser).transform(points)
            for k, points in zip(self.scans, self.points, strict=True)
            if before is None or k < before
        ]
        return np.concatenate([np.empty((0, 2)), *parts])


def scan_points(record: RunRecord) -> ScanPoints:
    """Read the points of all mapped scans from the log of the run; InputError if it has none."""
    mapped = record.traces.steps["mapped"] == 1
    seen = [(k, o.scan.points()) for k, (o, use) in enumerate(zip(record.observations(), mapped, strict=False)) if use]
    return ScanPoints([k for k, _ in seen], [points for _, points in seen], record.T_base_laser)


def fig_15(record: RunRecord, scans: ScanPoints) -> Figure:
    """Draw one match, half-way: the segments of the scan on the map of the steps before; sensor frame, x up."""
    k = scans.scans[len(scans.scans) // 2]
    pose = Pose2D.from_array(record.traces.estimate[k]) @ scans.T_base_laser
    reach = float(np.abs(scans.points[len(scans.scans) // 2]).max(initial=1.0)) * 1.05
    number, ends = record.segments
    figure = Figure(figsize=(5.2, 5.2), layout="constrained")
    axes = figure.add_subplot()
    _points(axes, _upright(pose.inverse().transform(scans.placed(record.traces.estimate, before=k))))
    _segments(axes, _upright(pose.inverse().transform(ends[number == k])), 1.0)
    axes.plot(0.0, 0.0, "+", color=_PINK, markersize=14, markeredgewidth=2)
    axes.annotate("", (0.0, 0.12 * reach), (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": _PINK})
    axes.set(xlabel="-y [m]", ylabel="x [m]", xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_title(f"step k = {k}", fontsize="medium")
    return figure


def fig_16(record: RunRecord, scans: ScanPoints) -> Figure:
    """Draw the final map, every segment that made it, and the sensor's pose at every step."""
    poses = stack_poses(Pose2D.from_array(row) @ scans.T_base_laser for row in record.traces.estimate[scans.scans])
    ends = record.segments[1]
    extent = np.ptp(np.concatenate([ends.reshape(-1, 2), poses[:, :2]]), axis=0)
    size = figure_size(8.0 * extent / extent.max(), (3.0, 2.5), (0.6, 0.6))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    _points(axes, scans.placed(record.traces.estimate))
    _segments(axes, ends, 0.5)
    axes.plot(*poses.T[:2], "+", color=_PINK, markersize=9, zorder=5)
    some = poses[:: max(1, len(poses) // 25)]
    axes.quiver(
        *some.T[:2], np.cos(some[:, 2]), np.sin(some[:, 2]), color=_PINK, angles="xy", units="inches", scale=4,
        width=0.015, zorder=6,
    )  # fmt: skip
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return figure


def fig_21(record: RunRecord, scans: ScanPoints) -> Figure:
    """Draw panels (a) to (c) of the paper's figure of maps.

    (a) is the environment if it is known, (b) the map of dead reckoning with its path in orange, (c) the line map with
    the estimated path in blue.
    """
    outlines = record.outlines
    count = 3 if outlines else 2
    wide = bool(np.greater(*np.ptp(record.traces.odometry[:, :2], axis=0)))
    figure = Figure(figsize=(8.0, 2.2 * count) if wide else (3.6 * count, 5.6), layout="constrained")
    panels = list(figure.subplots(*((count, 1) if wide else (1, count)), sharex=True, sharey=True))
    if outlines:
        panels[0].add_collection(PolyCollection(outlines, facecolors="0.75", edgecolors="0.3", linewidths=0.6))
        panels[0].autoscale_view()
    reckoned = scans.placed(record.traces.odometry)
    panels[-2].plot(*_thinned(reckoned).T, ",", color="0.35", rasterized=True)
    panels[-2].plot(*record.traces.odometry.T[:2], color=PAPER.odometry, linewidth=1.2)
    _segments(panels[-1], record.walls, min(1.0, (300 / max(len(record.walls), 1)) ** 0.5))
    panels[-1].plot(*record.traces.estimate.T[:2], color=PAPER.slam, linewidth=1.2, zorder=6)
    for letter, axes in zip("abc"[3 - count :], panels, strict=True):
        axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        axes.label_outer()
        axes.set_title(f"({letter})", loc="left", fontsize="medium")
    return figure


def _points(axes: Axes, points: FloatArray) -> None:
    axes.plot(*_thinned(points).T, "+", color=_PINK, markersize=2.5, markeredgewidth=0.4, rasterized=True, zorder=1)


def _segments(axes: Axes, ends: FloatArray, size: float) -> None:
    """Draw black lines from a blue □ to an orange ○."""
    axes.add_collection(LineCollection(list(ends), colors="black", linewidths=0.4 + size, zorder=3))
    for end, marker, colour in ((0, "s", _START), (1, "o", _END)):
        axes.plot(
            *ends[:, end].T, linestyle="none", marker=marker, markeredgecolor=colour, markerfacecolor="none",
            markersize=0.8 + 5.5 * size, markeredgewidth=0.15 + 0.75 * size, zorder=4, rasterized=len(ends) > 2000,
        )  # fmt: skip


def _thinned(points: FloatArray) -> FloatArray:
    return points[:: len(points) // _EVERY + 1]


def _upright(points: FloatArray) -> FloatArray:
    """Rotate points (..., 2) of the sensor frame so that x points up."""
    return np.stack([-points[..., 1], points[..., 0]], axis=-1)
