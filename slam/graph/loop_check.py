"""Verification of a loop: the key scans of one submap against another, less what their beams see through."""

from typing import Final, NamedTuple

import numpy as np

from slam.config import SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.mapping.free_beams import free_beams
from slam.mapping.free_space import count_seen_through
from slam.mapping.surfel_grid import Grid
from slam.matching.least_squares import SolverSettings, solve
from slam.pose import FloatArray

LEAST_FACETS: Final = 5
"""A scan with fewer facets says nothing."""
PRIOR_INFORMATION: Final = np.diag(1.0 / np.array([0.1, 0.1, 0.03]) ** 2)
"""Of the place of a key scan, given that of its submap: metres and radians."""
AGREEING: Final = 0.5, 0.7
"""Share of the facets that must agree, and share of that with which the scan agreed with its own submap: the lesser."""


class KeyMatch(NamedTuple):
    """A key scan matched to another submap."""

    key: int
    """Its number."""
    pose: FloatArray
    """(3,), in the frame ``local`` of the other submap."""
    information: FloatArray
    """(3, 3), in the same axes."""
    agreement: float
    """Share of the facets that agree, less the surfels that its beams saw through, counted as facets."""
    agrees: bool


def match_key(
    number: int, key: KeyScan, pose: FloatArray, grid: Grid, settings: SolverSettings, config: SurfelMapConfig
) -> KeyMatch | None:
    """Match a key scan that is thought to be at ``pose`` (3,) in the map of another submap; None where it has nothing
    to say."""
    count = len(key.facets)
    if count < LEAST_FACETS:
        return None
    fit = solve(key.facets, pose, pose, PRIOR_INFORMATION, grid, settings)
    beams = free_beams(key.scan, config.no_echo_reach)
    through = count_seen_through(grid, beams, fit.pose, config.carve_reach, config.free_margin)
    agreement = (fit.inliers - through) / count
    scale = np.array([1.0, 1.0, settings.lever])
    constrained = fit.projector * np.outer(1.0 / scale, scale)
    information = constrained.T @ fit.information @ constrained
    return KeyMatch(number, fit.pose, information, agreement, agreement > min(AGREEING[0], AGREEING[1] * key.share))
