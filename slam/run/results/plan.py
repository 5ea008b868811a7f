"""What was mapped, from above, on axes in metres: true walls, the map, and the ways that the robot went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from slam.files.palette import Palette
from slam.pose import FloatArray, Pose2D
from slam.scenario.solids import rectangle

_MAX_POINTS: Final = 200_000
"""More map points than this are thinned evenly for the picture: it shows no more."""
_MANY: Final = 3000
"""So many segments are drawn as pixels also where the rest is drawn as curves."""
_MIDDLE: Final = "#7d8590"
"""Of what is drawn as pixels, which no theme can change: seen on light and on dark."""
_FEW: Final = 500
"""From so many segments on, lines become fainter."""
ROBOT: Final = rectangle((-0.045, 0.0), 0.51, 0.38, 0.0)
"""The P3-DX, base frame, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Metres, map frame."""

    walls: FloatArray
    """(M, 2, 2): start and end of each line of the map."""
    estimate: FloatArray
    """(K, 3) poses: x, y, heading."""
    odometry: FloatArray
    truth: FloatArray | None = None
    outlines: Sequence[FloatArray] = ()
    """(C, 2) each: the true walls."""
    points: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner: all paths and true walls, and what was mapped but for the farthest 0.2 %."""
        ways = [way[:, :2] for way in (self.estimate, self.odometry, self.truth) if way is not None]
        mapped = np.concatenate([self.points, self.walls.reshape(-1, 2)])
        bulk = np.percentile(mapped, [0.1, 99.9], axis=0) if len(mapped) else np.empty((0, 2))
        corners = np.concatenate([bulk, *ways, *self.outlines])
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = 0.02 * float((high - low).max()) + 0.2
        return low - margin, high + margin


def draw_plan(axes: Axes, plan: Plan, colours: Palette) -> None:
    """Draw all of it, with labels for a legend."""
    low, high = plan.extent
    axes.add_collection(
        PolyCollection(
            list(plan.outlines), facecolors=colours.solid, edgecolors=colours.edge, linewidths=0.4, zorder=1,
            label="true walls" if len(plan.outlines) else "_",
        )
    )  # fmt: skip
    thinned = plan.points[:: len(plan.points) // _MAX_POINTS + 1]
    axes.plot(*thinned.T, ",", color=colours.point, alpha=0.4, zorder=2, rasterized=True)
    strength = max(0.25, min(1.0, (_FEW / max(len(plan.walls), 1)) ** 0.5))
    many = len(plan.walls) > _MANY
    axes.add_collection(
        LineCollection(
            list(plan.walls), colors=_MIDDLE if many else colours.wall, linewidths=0.5 + 1.1 * strength,
            alpha=0.4 + 0.6 * strength, zorder=3, capstyle="round", label="mapped lines", rasterized=many,
        )
    )  # fmt: skip
    _draw_ways(axes, plan, colours)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]", aspect="equal")


def _draw_ways(axes: Axes, plan: Plan, colours: Palette) -> None:
    axes.plot(*plan.odometry.T[:2], color=colours.odometry, linewidth=1.3, label="dead reckoning", zorder=4)
    axes.plot(*plan.odometry[-1, :2], "o", color=colours.odometry, markersize=4, zorder=4)
    axes.plot(*plan.estimate.T[:2], color=colours.slam, linewidth=2.0, label="SLAM", zorder=5)
    if plan.truth is not None:
        axes.plot(*plan.truth.T[:2], color=colours.truth, linewidth=0.8, dashes=(4, 3), label="truth", zorder=6)
    robot = Pose2D(*plan.estimate[-1]).transform(ROBOT)
    axes.fill(*robot.T, facecolor=colours.slam, alpha=0.35, linewidth=0.0, zorder=7)
    axes.fill(*robot.T, facecolor="none", edgecolor=colours.slam, linewidth=1.2, zorder=7)


def plain_axes(axes: Axes, colours: Palette) -> None:
    """A light frame and grid, in the colours of the palette."""
    axes.set_facecolor("none")
    axes.grid(color=colours.grid, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(colours.faint)
    axes.tick_params(colors=colours.faint, labelcolor=colours.ink, labelsize=9, length=2.5)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_color(colours.ink)
        label.set_fontsize(9)
    axes.title.set_color(colours.ink)
