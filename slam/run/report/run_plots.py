"""The curves of a run: errors with their bounds, iterations, processing time."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator

from slam.pose import FloatArray, path_lengths
from slam.run.pictures.figure_style import PAPER, Palette, plain_axes
from slam.run.results.traces import Traces, pose_errors

_LEGEND: Final = 66
"""Characters side by side in a legend."""
_CLOSED_DASH: Final = "--"
SIGMAS: Final = 3.0
"""Half width of the band about zero, in standard deviations of the estimate."""
CAPTIONS: Final = {
    "distance": "Position error over the distance travelled.",
    "iterations": "Iterations of the matcher.",
    "timing": "Processing time of the mapped scans.",
}
_ROWS: Final = (("x", "cov_xx", 100.0, "cm"), ("y", "cov_yy", 100.0, "cm"), ("heading", "cov_thth", 180 / np.pi, "deg"))


def error_figure(traces: Traces, colours: Palette = PAPER) -> Figure:
    """Draw estimate minus true pose over time, in x, y and heading, with the bound that the estimate claims.

    Without a true pose, it is the estimate minus dead reckoning.
    """
    known = traces.truth is not None
    against = traces.odometry if traces.truth is None else traces.truth
    errors = pose_errors(traces.estimate, against)
    figure = Figure(figsize=(5.4, 4.8))
    figure.subplots_adjust(0.13, 0.095, 0.965, 0.985, hspace=0.12)
    rows = figure.subplots(3, 1, sharex=True)
    for axes, column, (name, variance, scale, unit) in zip(rows, errors.T, _ROWS, strict=True):
        plain_axes(axes, colours)
        if known and has_variance(traces, variance):
            bound = SIGMAS * scale * np.sqrt(traces.steps[variance])
            axes.fill_between(traces.stamps, -bound, bound, color=colours.slam, alpha=0.18, linewidth=0.0)
        axes.plot(traces.stamps, scale * column, color=colours.slam, linewidth=1.1, label="SLAM, during the run")
        axes.set_ylabel(f"{name} {'error' if known else 'correction'} [{unit}]")
    axes.set_xlabel("time [s]")
    if traces.closed is not None:
        for axes, column, (_, _, scale, _) in zip(rows, pose_errors(traces.closed, against).T, _ROWS, strict=True):
            axes.plot(
                traces.stamps,
                scale * column,
                _CLOSED_DASH,
                color=colours.loop,
                linewidth=1.1,
                label="loops closed",
            )
        _legend(rows[0], colours)
    return figure


def _panel(colours: Palette) -> tuple[Figure, Axes]:
    """Make a figure with one pair of axes. Its margins are fixed, as computing them takes as long as drawing."""
    figure = Figure(figsize=(5.4, 3.0))
    figure.subplots_adjust(0.14, 0.15, 0.965, 0.9)
    axes = figure.add_subplot()
    plain_axes(axes, colours)
    return figure, axes


def _plain_numbers(axis: Axis) -> None:
    """Format 0.01 instead of a power of ten, on a logarithmic axis."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def has_variance(traces: Traces, column: str) -> bool:
    """Return True if the steps of the run have this column of the covariance."""
    return column in (traces.steps.dtype.names or ()) and bool(np.isfinite(traces.steps[column]).any())


def distance_figure(runs: Sequence[tuple[str, Traces]], colours: Palette = PAPER) -> Figure | None:
    """Draw the position error over the distance, of each run with a true pose.

    For a single run, also dead reckoning's.
    """
    known = [(name, traces, traces.truth) for name, traces in runs if traces.truth is not None]
    if not known:
        return None
    figure, axes = _panel(colours)
    for k, (name, traces, truth) in enumerate(known):
        distances = path_lengths(truth)
        alone, (colour, dash) = len(runs) == 1, colours.curve(k)
        axes.plot(
            distances, _off(traces.estimate, truth), dash, color=colour, linewidth=1.3, label="SLAM" if alone else name
        )
        if alone:
            if traces.closed is not None:
                off = _off(traces.closed, truth)
                axes.plot(distances, off, _CLOSED_DASH, color=colours.loop, linewidth=1.3, label="loops closed")
            axes.plot(
                distances, _off(traces.odometry, truth), color=colours.odometry, linewidth=1.1, label="dead reckoning"
            )
    axes.set(yscale="log", xlabel="distance travelled [m]", ylabel="position error [m]")
    _plain_numbers(axes.yaxis)
    _legend(axes, colours)
    return figure


def iterations_figure(runs: Sequence[tuple[str, Traces]], colours: Palette = PAPER) -> Figure:
    """Draw the iterations of the matcher, scan by scan; dots where it did not converge."""
    figure, axes = _panel(colours)
    for k, (name, traces) in enumerate(runs):
        matched = (traces.steps["mapped"] == 1) & (traces.steps["iterations"] > 0)
        stuck = matched & (traces.steps["converged"] == 0)
        iterations, (colour, dash) = traces.steps["iterations"], colours.curve(k)
        axes.plot(traces.stamps[matched], iterations[matched], dash, color=colour, linewidth=0.9, label=name)
        if stuck.any() and len(runs) == 1:
            axes.plot(traces.stamps[stuck], iterations[stuck], ".", color=colours.odometry, markersize=4,
                      label="not converged")  # fmt: skip
    axes.set(xlabel="time [s]", ylabel="iterations q", ylim=(0.0, None))
    _legend(axes, colours)
    return figure


def timing_figure(runs: Sequence[tuple[str, Traces]], colours: Palette = PAPER) -> Figure:
    """Draw a histogram of the time of a scan: the whole of SLAM, and for a single run also line extraction."""
    figure, axes = _panel(colours)
    for k, (name, traces) in enumerate(runs):
        mapped = traces.steps[traces.steps["mapped"] == 1]
        alone = len(runs) == 1
        _histogram(axes, mapped["slam_ms"], colours.curve(k), "all of SLAM" if alone else name)
        if alone:
            _histogram(axes, mapped["extraction_ms"], colours.curve(1), "line extraction")
    axes.set(xscale="log", xlabel="time of one mapped scan [ms]", ylabel="scans")
    _plain_numbers(axes.xaxis)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    _legend(axes, colours)
    return figure


def _histogram(axes: Axes, milliseconds: FloatArray, look: tuple[str, str], label: str) -> None:
    colour, dash = look
    positive = milliseconds[milliseconds > 0.0]
    if len(positive):
        bins = np.geomspace(positive.min() * 0.95, positive.max() * 1.05, 60)
        axes.hist(positive, bins=list(bins), histtype="stepfilled", color=colour, alpha=0.25)
        axes.hist(positive, bins=list(bins), histtype="step", color=colour, linestyle=dash, linewidth=1.1, label=label)


def _off(poses: FloatArray, truth: FloatArray) -> FloatArray:
    """Return the position error, metres, never quite zero, for a logarithmic axis."""
    off: FloatArray = np.maximum(np.hypot(*(poses - truth)[:, :2].T), 1e-4)
    return off


def _legend(axes: Axes, colours: Palette) -> None:
    names = axes.get_legend_handles_labels()[1]
    if len(names) > 1:
        columns = max(1, min(3, _LEGEND // (max(map(len, names)) + 6)))
        axes.legend(
            frameon=False, fontsize="small", labelcolor=colours.ink, ncols=columns, loc="lower left",
            bbox_to_anchor=(-0.02, 0.99), borderaxespad=0.0, handlelength=1.6, columnspacing=1.4,
        )  # fmt: skip
