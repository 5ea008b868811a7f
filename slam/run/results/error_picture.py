"""``errors.png``: errors and iterations step by step, in the manner of Figs. 17 to 20."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from slam.files.figure_file import save_figure
from slam.files.palette import PAPER
from slam.files.whole_files import whole_file
from slam.run.results.plan import plain_axes
from slam.run.results.traces import Traces, pose_errors

_ROWS = (("x", 100.0, "cm"), ("y", 100.0, "cm"), ("heading", 180.0 / np.pi, "deg"))


def draw_errors(folder: Path) -> None:
    """Write ``errors.png`` into a run folder that has at least one step.

    Against the truth where there is one; otherwise what SLAM says less what the odometry says.
    """
    traces = Traces.read(folder)
    if traces is None:
        return
    known = traces.truth is not None
    errors = pose_errors(traces.estimate, traces.odometry if traces.truth is None else traces.truth)
    figure = Figure(figsize=(9, 9), dpi=110, layout="constrained")
    rows = figure.subplots(4, 1, sharex=True)
    for axes in rows:
        plain_axes(axes, PAPER)
    for axes, column, (name, scale, unit) in zip(rows, errors.T, _ROWS, strict=False):
        axes.axhline(0.0, color=PAPER.faint, linewidth=0.8)
        axes.plot(scale * column, color=PAPER.slam, linewidth=1.1)
        axes.set_ylabel(f"{name} {'error' if known else 'correction'} [{unit}]")
    mapped = np.flatnonzero(traces.steps["mapped"] == 1)
    rows[3].plot(mapped, traces.steps["iterations"][mapped], color=PAPER.accent, linewidth=0.9)
    rows[3].set(ylabel="iterations q", xlabel="step k", ylim=(0.0, None))
    title = "Estimate less truth" if known else "Estimate less dead reckoning (no ground truth)"
    figure.suptitle(title, fontsize="medium", color=PAPER.ink)
    with whole_file(folder / "errors.png") as draft:
        save_figure(figure, draft)
