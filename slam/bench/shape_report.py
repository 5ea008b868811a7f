"""Whether the maps of the recorded logs have the shape of buildings: walls in line, loops that meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from slam.bench.crispness import end_points
from slam.bench.loop_fit import loop_fit
from slam.bench.slam_runs import SlamRun
from slam.console.result_table import ResultTable
from slam.pose import FloatArray

LONG: Final = 2.0
"""Metres that a wall must have, for its direction to be told."""
LOOPS: Final = {"duke_loop5": (50, 73)}
"""Logs that enter again where they began, and how many scans at the beginning and at the end show the same place."""
REACH: Final = 8.0
"""Metres up to which these scans are compared."""


def shape_table(found: Sequence[tuple[str, SlamRun]]) -> ResultTable:
    """A row for every log."""
    columns = (
        "log", f"walls of\n{LONG:g} m", "off axes\nrms, deg", "most\ndeg", "open along\nm", "across\nm", "heading\ndeg",
        "agree", "unmoved",
    )  # fmt: skip
    notes = (
        "Off axes: the directions of the walls, modulo 90 deg, about their mean, weighed by length; a building with "
        "walls at other angles has more. Open: what lays the last scans onto the first, along and across the first "
        "heading; the share of their points, one a 5 cm cell, that then agree, and that did before."
    )
    return ResultTable("Shapes", columns, [(name, *_walls(run.walls), *_loop(run)) for name, run in found], notes)


def off_axes(walls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far each wall (M, 2, 2) is turned from the common directions of all, modulo a right angle, radians, and the
    lengths, metres: (M,) each."""
    way = walls[:, 1] - walls[:, 0]
    lengths, fourfold = np.hypot(*way.T), np.exp(4j * np.arctan2(way[:, 1], way[:, 0]))
    return np.angle(fourfold / np.sum(lengths * fourfold)) / 4.0, lengths


def _walls(walls: FloatArray) -> tuple[str, str, str]:
    long = walls[np.hypot(*(walls[:, 1] - walls[:, 0]).T) >= LONG]
    if not len(long):
        return "0", "", ""
    angles, lengths = off_axes(long)
    spread = np.sqrt(np.average(angles**2, weights=lengths))
    return str(len(long)), f"{np.degrees(spread):.2f}", f"{np.degrees(np.abs(angles).max()):.1f}"


def _loop(run: SlamRun) -> tuple[str, ...]:
    if run.name not in LOOPS:
        return ("",) * 5
    begin, end = LOOPS[run.name]
    count = len(run.poses)
    fit = loop_fit(_seen(run, range(begin)), _seen(run, range(count - end, count)), float(run.poses[0, 2]))
    return (
        f"{fit.along:.2f}", f"{fit.across:.2f}", f"{np.degrees(fit.turn):.2f}", f"{fit.agreement:.2f}",
        f"{fit.before:.2f}",
    )  # fmt: skip


def _seen(run: SlamRun, scans: Sequence[int]) -> FloatArray:
    deskew = run.log.time_increment > 0.0
    return np.concatenate([end_points(run.log, k, run.poses[k], 0, REACH, deskew) for k in scans])
