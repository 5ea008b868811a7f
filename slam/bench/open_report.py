"""Runs that the scans leave open in one direction: what is odometry's there, and what the scans must hold across it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.bench.sim_runs import SimRun
from slam.console.result_table import ResultTable
from slam.pose import FloatArray

OPEN: Final = 0.5
"""Share of the scans that must leave a direction to odometry, for a run to be in the table."""


def open_tables(runs: Sequence[tuple[str, int, SimRun]]) -> list[ResultTable]:
    """A table of those runs that were open for most of their way, and of nothing where there is none."""
    chosen = [(name, seed, run) for name, seed, run in runs if run.open[1:].mean() > OPEN]
    if not chosen:
        return []
    found = np.array([_errors(run) for *_, run in chosen])
    labels = [f"{name}, {seed}" for name, seed, _ in chosen]
    summary = [("median", *_cells(np.median(found, axis=0))), ("worst", *_cells(_worst(found)))]
    columns = (
        "scenario, seed", "along\nend, cm", "odometer", "odometry", "across\nmost, cm", "across\nrms, cm",
        "heading\nmost, deg", "open",
    )  # fmt: skip
    notes = (
        "Along the way from the first to the last true place, and across it. Odometer: what odometry's way is off by, "
        "were its heading right, which is all that is known there; odometry: with its heading as it was."
    )
    rows = [(label, *_cells(row)) for label, row in zip(labels, found, strict=True)]
    return [ResultTable("Where the scans leave a direction open", columns, [*rows, *summary], notes)]


def _errors(run: SimRun) -> FloatArray:
    """Of one run: centimetres, degrees, and the share of open scans."""
    way = run.truth[-1, :2] - run.truth[0, :2]
    along = way / np.hypot(*way)
    across = 100.0 * np.abs(run.offsets[:, :2] @ np.array([-along[1], along[0]]))
    ends = [abs(100.0 * offsets[-1, :2] @ along) for offsets in _compared(run)]
    turned = np.degrees(np.abs(run.offsets[:, 2])).max()
    return np.array([*ends, across.max(), np.sqrt(np.mean(across**2)), turned, run.open[1:].mean()])


def _compared(run: SimRun) -> tuple[FloatArray, FloatArray, FloatArray]:
    return run.offsets, run.odometer_offsets, run.odometry_offsets


def _worst(found: FloatArray) -> FloatArray:
    """The greatest error of each kind, and the least share."""
    return np.append(found[:, :-1].max(axis=0), found[:, -1].min())


def _cells(row: FloatArray) -> list[str]:
    return [*(f"{value:.2f}" for value in row[:-1]), f"{100 * row[-1]:.0f} %"]
