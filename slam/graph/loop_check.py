"""Verification of a loop: the key scans of one submap against another, with a penalty for beams through walls."""

from typing import Final, NamedTuple

import numpy as np

from slam.config import SurfelMapConfig
from slam.graph.submap import Submap
from slam.graph.submap_view import SubmapView
from slam.lines.segments import IntArray
from slam.mapping.free_space import count_seen_through
from slam.mapping.surfel_grid import Grid
from slam.matching.least_squares import SolverSettings, solve
from slam.pose import FloatArray, compose_poses

MIN_FACETS: Final = 5
"""Least number of facets of a scan that is tested."""
PRIOR_INFORMATION: Final = np.diag(1.0 / np.array([0.1, 0.1, 0.03]) ** 2)
"""Information of the pose of a key scan, given that of its submap: metres and radians."""
AGREEING: Final = 0.5, 0.7
"""A key scan agrees if its agreement exceeds the first number, or the second times the share of its facets that agreed
with its own submap."""
NEAR: Final = 3.0
"""Distance to the path of the other submap within which a key scan is tested, metres."""
MIN_AGREEING, MIN_AGREEING_SHARE = 2, 0.5
"""Least number of agreeing key scans, and their least share of the tested ones."""
FIRST_ASKED: Final = 5
"""Number of key scans that are tested first; if too few of them agree, the others are not tested."""
SLIDES: Final = (-1.6, -0.8, -0.4, 0.4, 0.8, 1.6)
"""Shifts along the least constrained direction for a second test of the key scans, metres."""
MAX_SLID: Final = 6
"""Largest number of key scans in that test."""
SLIDING_AGREEMENT: Final = 0.85
"""Share of its agreement that a key scan must keep in that test for the direction to count as unconstrained."""


class KeyMatch(NamedTuple):
    """A key scan matched to another submap."""

    at: int
    """Index of the key scan in its submap."""
    pose: FloatArray
    """(3,): pose in the frame ``local`` of the other submap."""
    information: FloatArray
    """(3, 3): information, in the same axes."""
    agreement: float
    """Share of agreeing facets, minus the surfels that its beams went through, counted as facets."""
    agrees: bool


class Check(NamedTuple):
    """Result of the tested key scans for one pose of the submap."""

    T_other_submap: FloatArray
    """(3,): pose between the frames ``local`` of the two submaps."""
    matches: list[KeyMatch]
    """Matches of the tested key scans."""

    @property
    def agreement(self) -> float:
        """Sum of the agreement over the tested key scans."""
        return sum(match.agreement for match in self.matches)

    @property
    def agreeing(self) -> list[KeyMatch]:
        """The matches that agree."""
        return [match for match in self.matches if match.agrees]

    @property
    def passed(self) -> bool:
        """True if enough of them agree."""
        return len(self.agreeing) >= max(MIN_AGREEING, MIN_AGREEING_SHARE * len(self.matches))


class LoopCheck:
    """Tests, key scan by key scan, whether a submap lies at a pose in another one."""

    def __init__(self, settings: SolverSettings, config: SurfelMapConfig) -> None:
        self._settings = settings._replace(first_kernel=4.0 * settings.kernel)
        self._config = config

    def check(self, view: SubmapView, T_other_submap: FloatArray, other: Submap, grid: Grid) -> Check:
        """Test all key scans near the other's path."""
        poses = compose_poses(T_other_submap, view.path)
        near = np.flatnonzero(distances_to(poses, other.path) <= NEAR)
        first = near[np.unique(np.linspace(0, len(near) - 1, min(FIRST_ASKED, len(near))).round().astype(np.int64))]
        found = Check(T_other_submap, self._matches(view, first, poses, grid))
        if 2 * len(found.agreeing) < len(found.matches):
            return found
        rest = np.setdiff1d(near, first)
        return Check(T_other_submap, [*found.matches, *self._matches(view, rest, poses, grid)])

    def open_direction(self, view: SubmapView, check: Check, grid: Grid) -> FloatArray | None:
        """Return the direction (2,) along which the submap may slide with nearly the same agreement, as in a corridor.

        None if there is none.
        """
        asked = check.agreeing
        asked = [asked[k] for k in np.unique(np.linspace(0, len(asked) - 1, MAX_SLID).round().astype(np.int64))]
        information = np.sum([match.information[:2, :2] for match in asked], axis=0)
        direction: FloatArray = np.linalg.eigh(information)[1][:, 0]
        agreement = sum(match.agreement for match in asked)
        at = np.array([match.at for match in asked])
        poses = np.array([match.pose for match in asked])
        for slide in SLIDES:
            slid = poses + slide * np.append(direction, 0.0)
            matches = [self._match(view, int(a), pose, grid) for a, pose in zip(at, slid, strict=True)]
            if sum(match.agreement for match in matches) > SLIDING_AGREEMENT * agreement:
                return direction
        return None

    def _matches(self, view: SubmapView, asked: IntArray, poses: FloatArray, grid: Grid) -> list[KeyMatch]:
        numbers = [at for at in asked.tolist() if len(view.keys[at].facets) >= MIN_FACETS]
        return [self._match(view, at, poses[at], grid) for at in numbers]

    def _match(self, view: SubmapView, at: int, pose: FloatArray, grid: Grid) -> KeyMatch:
        """Match a key scan, starting at ``pose`` (3,) in the map of another submap."""
        key, config, settings = view.keys[at], self._config, self._settings
        fit = solve(key.facets, pose, pose, PRIOR_INFORMATION, grid, settings)
        through = count_seen_through(grid, view.beams(at), fit.pose, config.carve_reach, config.free_margin)
        agreement = (fit.inliers - through) / len(key.facets)
        scale = np.array([1.0, 1.0, settings.lever])
        constrained = fit.projector * np.outer(1.0 / scale, scale)
        information = constrained.T @ fit.information @ constrained
        return KeyMatch(
            at, fit.pose, information, agreement, agreement > min(AGREEING[0], AGREEING[1] * key.agreeing_share)
        )


def distances_to(path: FloatArray, other: FloatArray) -> FloatArray:
    """Return the distance from each pose (K, 3) to the nearest of the others (J, 3), metres, shape (K,)."""
    offsets = path[:, None, :2] - other[None, :, :2]
    return np.asarray(np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1))
