"""Score of matchers: speed, basin of convergence and accuracy."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from time import perf_counter
from typing import Final

import numpy as np

from slam.bench.match_scenes import PlacedScan
from slam.bench.matchers import Matcher
from slam.pose import FloatArray, Pose2D

BEAMS: Final = (85, 170, 341, 682, 1364, 2728)
SHIFTS: Final = (0.0, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0)
"""Distances between the start and the true pose, metres, in four directions."""
TURNS: Final = (0.0, 0.1, 0.2, 0.35, 0.5)
"""Heading errors of the start, radians, to both sides."""
CONVERGED: Final = 0.03, float(np.radians(1.0))
"""Largest error of a converged match, metres and radians."""
BLOCK: Final = 10
"""Scans per turn of a matcher."""
NEARBY: Final = 0.05, 0.03
"""Error of the start in the timed runs, metres and radians."""


@dataclass(frozen=True, slots=True, eq=False)
class MatchRuns:
    """Results of one matcher on many scans: K runs."""

    seconds: FloatArray
    """(K,) wall time, seconds."""
    errors: FloatArray
    """(K, 2): errors, metres and radians."""

    @property
    def converged(self) -> float:
        """Share of the runs that converged."""
        return float(np.mean((self.errors[:, 0] < CONVERGED[0]) & (self.errors[:, 1] < CONVERGED[1])))


def match_in_turns(
    matchers: Sequence[Matcher], scans: Sequence[PlacedScan], start_poses: Sequence[Pose2D]
) -> dict[str, MatchRuns]:
    """Match every scan from every start, relative to the true pose; return the results by the matchers' names.

    The matchers take turns with blocks of scans: other load on the machine affects all alike, and each has its code and
    map in the caches, as in a loop of its own.
    """
    for matcher in matchers:
        matcher.match(scans[0].scan, scans[0].T_map_laser)  # compiles
    rows: dict[str, list[tuple[float, float, float]]] = {matcher.name: [] for matcher in matchers}
    blocks = [scans[k : k + BLOCK] for k in range(0, len(scans), BLOCK)]
    for block, matcher in product(blocks, matchers):
        for placed, start in product(block, start_poses):
            begun = perf_counter()
            found = matcher.match(placed.scan, placed.T_map_laser @ start)
            taken, error = perf_counter() - begun, placed.T_map_laser.between(found)
            rows[matcher.name].append((taken, error.distance(Pose2D()), abs(error.theta)))
    tables = {name: np.array(measured) for name, measured in rows.items()}
    return {name: MatchRuns(table[:, 0], table[:, 1:]) for name, table in tables.items()}


def start_poses(shift: float, turn: float) -> list[Pose2D]:
    """Start poses in four directions, each with a turn to one side."""
    bearings = 0.4 + 0.5 * np.pi * np.arange(4)
    return [
        Pose2D(float(shift * np.cos(bearing)), float(shift * np.sin(bearing)), turn * (-1.0) ** k)
        for k, bearing in enumerate(bearings)
    ]


def convergence_basin(matcher: Matcher, scans: Sequence[PlacedScan]) -> FloatArray:
    """Return the share of the runs that converged, (turns, shifts)."""
    return np.array(
        [
            [match_in_turns([matcher], scans, start_poses(shift, turn))[matcher.name].converged for shift in SHIFTS]
            for turn in TURNS
        ]
    )
