"""``map.png``: what was mapped, from above."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from slam.files.figure_file import save_figure
from slam.files.palette import PAPER, Palette
from slam.files.tum import read_tum
from slam.files.whole_files import whole_file
from slam.pose import FloatArray
from slam.run.results.plan import Plan, draw_plan, plain_axes


def draw_map(folder: Path, points: FloatArray, segment_ends: FloatArray, outlines: Sequence[FloatArray]) -> None:
    """Write ``map.png`` into a run folder that has at least one step.

    ``points`` (N, 2), ``segment_ends`` (M, 2, 2) and the true wall ``outlines`` are in metres, map frame; the
    trajectories are read from the folder.
    """
    estimate, odometry = (read_tum(folder / f"{name}.tum")[1] for name in ("trajectory", "odometry"))
    truth_file = folder / "groundtruth.tum"
    truth = read_tum(truth_file)[1] if truth_file.is_file() else None
    plan = Plan(segment_ends, estimate, odometry, truth, outlines, points)
    with whole_file(folder / "map.png") as draft:
        save_figure(map_figure(plan), draft, dpi=130)


def map_figure(plan: Plan, colours: Palette = PAPER, longest: float = 13.0, bare: bool = False) -> Figure:
    """The picture; at most ``longest`` inches wide. A ``bare`` one has neither title nor legend."""
    low, high = plan.extent
    figure = Figure(figsize=_size(high - low, longest), layout="constrained")
    axes = figure.add_subplot()
    plain_axes(axes, colours)
    draw_plan(axes, plan, colours)
    if bare:
        return figure
    if plan.truth is not None:
        axes.set_title(where_it_ends(plan, plan.truth), fontsize="medium", color=colours.ink)
    columns = max(2, round(float(figure.get_figwidth()) / 1.7))
    figure.legend(
        loc="outside upper center", ncols=columns, fontsize="small", frameon=False, labelcolor=colours.ink,
        handlelength=1.8,
    )  # fmt: skip
    return figure


def where_it_ends(plan: Plan, truth: FloatArray) -> str:
    """How far the ends of both ways are from the true one."""
    ends = (way[min(len(way), len(truth)) - 1] for way in (plan.estimate, plan.odometry))
    ours, off = (length(float(np.hypot(*(end - truth[-1])[:2]))) for end in ends)
    return f"SLAM ends {ours} from the truth, dead reckoning {off}"


def length(metres: float) -> str:
    """A distance for people: 7.1 m, 3.4 cm."""
    return f"{metres:.1f} m" if metres >= 0.995 else f"{100 * metres:.1f} cm"


def _size(extent: FloatArray, longest: float) -> tuple[float, float]:
    """Inches, in proportion to what is shown, with room for labels; neither side too short for the legend."""
    width, height = extent * min(longest / extent[0], 0.7 * longest / extent[1])
    return max(float(width), 0.5 * longest) + 0.6, max(float(height), 0.18 * longest) + 0.9
