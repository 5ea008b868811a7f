"""Figs. 17 to 20 of the paper, from a run: errors and iterations over the step k."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from slam.pose import FloatArray
from slam.run.results.traces import Traces, pose_errors

_ERRORS = (
    ("fig17", 100.0, "error in the X-axis [cm]"),
    ("fig18", 100.0, "error in the Y-axis [cm]"),
    ("fig19", 180.0 / np.pi, "error of the sensor angle φ [deg]"),
)


def paper_curves(traces: Traces) -> Iterator[tuple[str, Figure]]:
    """Each by its name; Figs. 17 to 19 only where the truth is known."""
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
