"""How open a loop is where a place is entered again, without any truth: the last scans laid onto the first."""

from __future__ import annotations

from itertools import product
from typing import Final, NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

from slam.pose import FloatArray

CELL: Final = 0.05
"""Metres: one point a cell is fitted."""
NEAR: Final = 0.075
"""Metres within which a point agrees with the first ones."""
STEPS: Final = ((1.0, 0.10, np.radians(6.0), np.radians(1.0)), (0.10, 0.025, np.radians(1.0), np.radians(0.25)))
"""Half window and step of the place, metres, and of the heading, radians; the second about the best of the first."""


class LoopFit(NamedTuple):
    """What the last points must be moved by to lie on the first ones."""

    along: float
    """Metres in the direction of ``heading`` that was asked for ..."""
    across: float
    """... and to its left."""
    turn: float
    """Radians, about the mean of the last points."""
    agreement: float
    """Share of the last points that then lie near the first."""
    before: float
    """The same as they were."""


def loop_fit(first: FloatArray, last: FloatArray, heading: float) -> LoopFit:
    """The best fit of the points ``last`` (M, 2) to ``first`` (N, 2), metres, along and across ``heading``, radians."""
    c, s = np.cos(heading), np.sin(heading)
    turned = np.array([[c, -s], [s, c]])  # from x, y to along, across, for rows
    first, last = _thinned(first @ turned), _thinned(last @ turned)
    near, corner = _picture(first)
    middle, best = last.mean(axis=0), np.zeros(3)
    for reach, step, reach_turn, step_turn in STEPS:
        best = max(
            _around(best, reach, step, reach_turn, step_turn), key=lambda t: _share(near, corner, last, middle, t)
        )
    agreement, before = (_share(near, corner, last, middle, moved) for moved in (best, np.zeros(3)))
    return LoopFit(float(best[0]), float(best[1]), float(best[2]), agreement, before)


def _thinned(points: FloatArray) -> FloatArray:
    return (np.unique(np.floor(points / CELL), axis=0) + 0.5) * CELL


def _picture(points: FloatArray) -> tuple[np.ndarray, FloatArray]:
    """Which cells, half as wide as CELL, are near a point, and the lower corner of the first of them."""
    margin = 4
    corner = points.min(axis=0) - 0.5 * CELL * margin
    index = np.floor((points - corner) / (0.5 * CELL)).astype(int)
    empty = np.ones(index.max(axis=0) + margin + 1, np.bool_)
    empty[tuple(index.T)] = False
    return distance_transform_edt(empty) * 0.5 * CELL <= NEAR, corner


def _around(best: FloatArray, reach: float, step: float, reach_turn: float, step_turn: float) -> list[FloatArray]:
    """The steps of a window, nearest first, so that of equals the least is taken."""
    places = np.arange(-round(reach / step), round(reach / step) + 1) * step
    turns = np.arange(-round(reach_turn / step_turn), round(reach_turn / step_turn) + 1) * step_turn
    window = np.array(list(product(places, places, turns)))
    return list(best + window[np.argsort(np.abs(window) @ np.ones(3), kind="stable")])


def _share(near: np.ndarray, corner: FloatArray, last: FloatArray, middle: FloatArray, moved: FloatArray) -> float:
    """Of the points that lie near the first ones, moved so (3,)."""
    c, s = np.cos(moved[2]), np.sin(moved[2])
    points = (last - middle) @ np.array([[c, s], [-s, c]]) + middle + moved[:2]
    index = np.floor((points - corner) / (0.5 * CELL)).astype(int)
    inside = np.all((index >= 0) & (index < near.shape), axis=1)
    return float(near[tuple(index[inside].T)].sum() / len(last))
