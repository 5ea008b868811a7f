"""Errors and iterations step by step: ``errors.png``, and Figs. 17 to 20 of the paper."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from slam.files.atomic_files import atomic_file
from slam.pose import FloatArray
from slam.run.pictures.figure_style import PAPER, plain_axes, save_figure
from slam.run.results.traces import Traces, pose_errors

_ROWS = (("x", 100.0, "cm"), ("y", 100.0, "cm"), ("heading", 180.0 / np.pi, "deg"))
_ERRORS = (
    ("fig17", 100.0, "error in the X-axis [cm]"),
    ("fig18", 100.0, "error in the Y-axis [cm]"),
    ("fig19", 180.0 / np.pi, "error of the sensor angle φ [deg]"),
)


def draw_errors(folder: Path) -> None:
    """Write ``errors.png`` into a run folder that has at least one step.

    It shows errors against the true pose if that is known; otherwise SLAM minus odometry.
    """
    traces = Traces.read(folder)
    if traces is None:
        return
    known = traces.truth is not None
    against = traces.odometry if traces.truth is None else traces.truth
    errors = pose_errors(traces.estimate, against)
    figure = Figure(figsize=(9, 9), dpi=110, layout="constrained")
    rows = figure.subplots(4, 1, sharex=True)
    for axes in rows:
        plain_axes(axes, PAPER)
    for axes, column, (name, scale, unit) in zip(rows, errors.T, _ROWS, strict=False):
        axes.axhline(0.0, color=PAPER.faint, linewidth=0.8)
        axes.plot(scale * column, color=PAPER.slam, linewidth=1.1, label="SLAM, during the run")
        axes.set_ylabel(f"{name} {'error' if known else 'correction'} [{unit}]")
    if traces.closed is not None:
        for axes, column, (_, scale, _) in zip(rows, pose_errors(traces.closed, against).T, _ROWS, strict=False):
            axes.plot(scale * column, "--", color=PAPER.loop, linewidth=1.1, label="loops closed")
        rows[0].legend(frameon=False, fontsize="small", ncols=2)
    mapped = np.flatnonzero(traces.steps["mapped"] == 1)
    rows[3].plot(mapped, traces.steps["iterations"][mapped], color=PAPER.accent, linewidth=0.9)
    rows[3].set(ylabel="iterations q", xlabel="step k", ylim=(0.0, None))
    title = "Estimate minus truth" if known else "Estimate minus dead reckoning (no ground truth)"
    figure.suptitle(title, fontsize="medium", color=PAPER.ink)
    with atomic_file(folder / "errors.png") as draft:
        save_figure(figure, draft)


def paper_curves(traces: Traces) -> Iterator[tuple[str, Figure]]:
    """Yield figures by name; Figs. 17 to 19 only if the true pose is known."""
    if traces.truth is not None:
        for (name, scale, label), error in zip(_ERRORS, pose_errors(traces.estimate, traces.truth).T, strict=True):
            yield name, _curve(np.arange(len(error)), scale * error, label)
    matched = np.flatnonzero((traces.steps["mapped"] == 1) & (traces.steps["iterations"] > 0))
    figure = _curve(matched, traces.steps["iterations"][matched], "iterations q")
    figure.axes[0].set_ylim(bottom=0.0)
    yield "fig20", figure


def _curve(steps: NDArray[Any], values: FloatArray, label: str) -> Figure:
    figure = Figure(figsize=(5.2, 3.0), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(steps, values, color="black", linewidth=0.9)
    axes.set(xlabel="step k", ylabel=label)
    axes.margins(x=0.01)
    return figure
