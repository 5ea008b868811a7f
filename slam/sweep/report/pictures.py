"""Pictures of a sweep's report."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slam.files.atomic_files import atomic_file
from slam.modes import MODES
from slam.pose import FloatArray
from slam.run.pictures.figure_style import PAPER, save_figure
from slam.sweep.report.groups import RunGroup, group_by_name

_CURVES: Final[list[str]] = sorted(MODES, key=lambda mode: mode == "paper")
"""Modes in the order in which they get their styles: SLAM and dead reckoning first, with their usual colours."""
_MARKERS: Final = "osD^vPX"
_LOG_SCALE_RATIO: Final = 20.0
"""Ratio of the largest to the smallest value above which the scale is logarithmic."""


def draw_boxes(path: Path, groups: list[RunGroup], metric: str) -> None:
    """Draw a panel per scenario: for each case the quartiles, whiskers to 5 and 95 %, and the outliers."""
    figure, panels = _panels(group_by_name(groups), metric)
    for axes, members in zip(panels, group_by_name(groups).values(), strict=True):
        shown = [group for group in members if group.values]
        boxes = axes.boxplot(
            [group.values for group in shown], whis=(5, 95), widths=0.6, patch_artist=True,
            medianprops={"color": "black"}, flierprops={"marker": ".", "markersize": 4},
        )  # fmt: skip
        for box, (colour, _) in zip(boxes["boxes"], _styles(shown), strict=True):
            box.set(facecolor=colour, alpha=0.5)
        axes.set_xticks(range(1, len(shown) + 1), [group.label.replace(", ", "\n") for group in shown])
        _scale(axes, shown)
    _save(figure, path)


def draw_bands(path: Path, groups: list[RunGroup]) -> None:
    """Draw a panel per scenario: the error over the distance driven, median of the runs and 5 to 95 % of them."""
    known = group_by_name([group for group in groups if group.curves])
    figure, panels = _panels(known, "error [m]")
    for axes, members in zip(panels, known.values(), strict=True):
        for group, (colour, dash) in zip(members, _styles(members), strict=True):
            distance, (low, middle, high) = _band(group.curves)
            axes.fill_between(distance, low, high, color=colour, alpha=0.2, linewidth=0)
            axes.plot(distance, middle, dash, color=colour, label=group.label)
        axes.set(xlabel="distance driven [m]", ylim=(0, None))
        axes.legend(fontsize="small", frameon=False)
    _save(figure, path)


def draw_samples(path: Path, groups: list[RunGroup], metric: str) -> None:
    """Draw a panel per drawn setting: the metric of every run over its value."""
    keys = sorted({key for group in groups for drawn in group.drawn for key in drawn})
    figure, panels = _panels(keys, metric)
    for axes, key in zip(panels, keys, strict=True):
        for number, (group, (colour, _)) in enumerate(zip(groups, _styles(groups), strict=True)):
            axes.plot(
                [drawn.get(key, np.nan) for drawn in group.drawn], group.values, _MARKERS[number % len(_MARKERS)],
                color=colour, alpha=0.6, markersize=3.5, label=f"{group.name}, {group.label}",
            )  # fmt: skip
        axes.set(title="", xlabel=key)
        _scale(axes, groups)
    panels[0].legend(fontsize="small", frameon=False)
    _save(figure, path)


def _panels(titles: Any, y_label: str) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(max(5.0 * len(titles), 6.0), 4.5), dpi=110, layout="constrained")
    panels = figure.subplots(1, len(titles), squeeze=False)[0]
    for axes, title in zip(panels, titles, strict=True):
        axes.set_title(title)
    panels[0].set_ylabel(y_label)
    return figure, panels


def _styles(groups: list[RunGroup]) -> list[tuple[str, str]]:
    """Return colour and line style of each case: those of its mode, if the modes distinguish the cases."""
    modes = [group.mode for group in groups]
    if len(set(modes)) == len(modes) and set(modes) <= set(_CURVES):
        return [PAPER.curve(_CURVES.index(mode)) for mode in modes]
    return [PAPER.curve(index) for index in range(len(groups))]


def _band(curves: list[tuple[float, list[float]]]) -> tuple[FloatArray, FloatArray]:
    """Return distances (M,), as far as half the runs went, and the 5, 50 and 95 % quantiles of the errors, (3, M)."""
    distance = np.linspace(0.0, float(np.median([path for path, _ in curves])), 200)
    errors = [np.interp(distance, np.linspace(0.0, path, len(errors)), errors, right=np.nan) for path, errors in curves]
    return distance, np.nanpercentile(np.array(errors), [5, 50, 95], axis=0)


def _scale(axes: Axes, groups: list[RunGroup]) -> None:
    values = np.array([value for group in groups for value in group.values])
    if len(values) and values.min() > 0 and values.max() > _LOG_SCALE_RATIO * values.min():
        axes.set_yscale("log")
    axes.grid(axis="y", color="0.9")


def _save(figure: Figure, path: Path) -> None:
    with atomic_file(path) as draft:
        save_figure(figure, draft, format="png")
