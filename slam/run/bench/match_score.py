"""How fast, how far and how well a matcher finds the pose of a scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Final

import numpy as np

from slam.pose import FloatArray, Pose2D
from slam.run.bench.match_scenes import PlacedScan
from slam.run.bench.matchers import Matcher

BEAMS: Final = (85, 170, 341, 682, 1364, 2728)
SHIFTS: Final = (0.0, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0)
"""Metres between the start and the truth, in four directions ..."""
TURNS: Final = (0.0, 0.1, 0.2, 0.35, 0.5)
"""... and radians, to both sides."""
CONVERGED: Final = 0.03, float(np.radians(1.0))
"""Metres and radians from the truth, at most."""
NEAR: Final = 0.05, 0.03
"""Start of the runs that are timed: metres and radians off."""


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """One matcher on many scans: K runs."""

    seconds: FloatArray
    """(K,) wall time."""
    errors: FloatArray
    """(K, 2): metres and radians from the truth."""

    @property
    def converged(self) -> float:
        """Share of the runs."""
        return float(np.mean((self.errors[:, 0] < CONVERGED[0]) & (self.errors[:, 1] < CONVERGED[1])))


def runs(matcher: Matcher, scans: Sequence[PlacedScan], starts: Sequence[Pose2D]) -> Runs:
    """Every scan from every start, which is given as seen from the truth."""
    matcher.match(scans[0].scan, scans[0].T_map_laser)  # compiles
    seconds, errors = [], []
    for placed in scans:
        for start in starts:
            begun = perf_counter()
            found = matcher.match(placed.scan, placed.T_map_laser @ start)
            seconds.append(perf_counter() - begun)
            error = placed.T_map_laser.between(found)
            errors.append((error.distance(Pose2D()), abs(error.theta)))
    return Runs(np.array(seconds), np.array(errors))


def starts(shift: float, turn: float) -> list[Pose2D]:
    """Four directions, each with a turn to one side."""
    bearings = 0.4 + 0.5 * np.pi * np.arange(4)
    return [
        Pose2D(float(shift * np.cos(bearing)), float(shift * np.sin(bearing)), turn * (-1.0) ** k)
        for k, bearing in enumerate(bearings)
    ]


def basin(matcher: Matcher, scans: Sequence[PlacedScan]) -> FloatArray:
    """Share that converged, (turns, shifts)."""
    return np.array([[runs(matcher, scans, starts(shift, turn)).converged for shift in SHIFTS] for turn in TURNS])
