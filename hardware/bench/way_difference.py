"""How far two ways of a robot through the same scenario are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from slam.pose import FloatArray, wrap_angles

_MOVES: Final = 0.01
"""Metres from one pose to the next: a robot that moves less stands, or turns on the spot."""
_LEG: Final = 1.0
"""Metres that a leg has at least."""
_STEP: Final = 0.005
"""Metres between the places of a way that are looked at."""
_NEW_LEG: Final = 0.5
"""Radians that a robot which stood has turned by if it begins another leg; else it stood for other reasons."""
_TURN: Final = 0.5
"""Metres from the ends of a leg within which the robot still turns into it, or already into the next."""


@dataclass(frozen=True, slots=True)
class WayDifference:
    """Of two ways at the same place along the route, whenever each came by; turns on the spot left out.

    The clocks of two runs start at different times; so each place of one way is compared with the nearest place of the
    other's same leg, which is the one abreast of it.
    """

    length: float
    """Metres that were compared."""
    largest: float
    """Between the places, metres ..."""
    rms: float
    """... and its root mean square."""
    heading: float
    """Between the headings there, the largest, radians, but for the turns at the ends of legs."""
    ends: float
    """Between the ends of the same leg, the largest, metres: a robot that arrives says so once a scan only."""

    @classmethod
    def between(cls, one: FloatArray, other: FloatArray) -> Self:
        """Of two ways of poses x, y, theta, (N, 3) and (M, 3), with as many legs."""
        legs = list(zip(_legs(one), _legs(other), strict=True))
        apart, turned = map(np.concatenate, zip(*(_abreast(a, b) for a, b in legs), strict=True))
        ends = max(float(np.hypot(*(a[-1] - b[-1])[:2])) for a, b in legs)
        rms = float(np.sqrt(np.mean(apart**2)))
        return cls(len(apart) * _STEP, float(apart.max()), rms, float(np.abs(turned).max()), ends)


def _legs(poses: FloatArray) -> Sequence[FloatArray]:
    """The pieces of a way between which the robot turns on the spot, each in steps of ``_STEP``."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], steps > _MOVES, [False]]).astype(int))).reshape(-1, 2)
    turns = np.abs(wrap_angles(poses[ends[1:, 0], 2] - poses[ends[:-1, 1], 2]))
    pieces = np.split(ends, np.flatnonzero(turns > _NEW_LEG) + 1)
    spans = [slice(piece[0, 0], piece[-1, 1] + 1) for piece in pieces]
    return [_resampled(poses[span]) for span in spans if steps[span].sum() > _LEG]


def _resampled(poses: FloatArray) -> FloatArray:
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
    at = np.arange(0.0, driven[-1], _STEP)
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    return np.column_stack([np.interp(at, driven, column) for column in columns])


def _abreast(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Metres and radians from each place of one leg to the nearest of the other, where that is not one of its ends.

    Radians are 0 near the ends.
    """
    nearest = np.array([np.argmin(np.sum((other[:, :2] - place) ** 2, axis=1)) for place in one[:, :2]])
    inside = (nearest > 0) & (nearest < len(other) - 1)
    difference = (one - other[nearest])[inside]
    turned = wrap_angles(difference[:, 2])
    near = round(_TURN / _STEP)
    turned[:near] = turned[-near:] = 0.0
    return np.hypot(difference[:, 0], difference[:, 1]), turned
