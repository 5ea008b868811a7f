"""Matches key scans to the whole map, so that old parts of the map limit the drift before the next loop is closed.

After a break of the front end only odometry connects the new key scans to the map. The pose in the map is then searched
with each key scan until one agrees; only then are the key scans since the break added to the map, as they would
otherwise agree with themselves only.
"""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.key_scan import KeyScan
from slam.graph.single_poses import composed, composed_with_inverse
from slam.mapping.directions import Directions
from slam.mapping.surfel_grid import Grid
from slam.matching.least_squares import SolverSettings, solve
from slam.matching.pose_search import PoseSearch, Scene
from slam.matching.wall_heading import WallHeading
from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D

SIGMAS: Final = np.array([0.02, 0.02, 0.0005])
"""Standard deviations of the drift of ``local`` in the map between key scans, metres and radians. The heading drifts
little: the walls of the submap and the main directions of the building hold it."""
BREAK_SIGMAS: Final = np.array([0.7, 0.7, 0.6])
"""Standard deviations of that drift after a break, metres and radians."""
AGREEING: Final = 0.5, 0.8
"""Least share of a key scan's facets that must agree with the map, and the same relative to the share that agrees with
the submap of the scan. The smaller of the two limits counts; after a break only the first is used."""
MAX_WAITING: Final = 20
"""Largest number of key scans after a break that were not found in the map: then the robot is in an unmapped area."""


class MapTracking:
    """Tracks the frame ``local`` in the map from key scan to key scan, and finds it again after a break."""

    def __init__(self, config: LeastSquaresConfig, map_config: SurfelMapConfig) -> None:
        shared = {name: getattr(config, name) for name in SolverSettings._fields if name != "standing_length"}
        self._settings = SolverSettings(**shared, standing_length=0.0)
        self._information = np.diag(SIGMAS**-2.0)
        self._search = PoseSearch(config.search, map_config.carve_reach, WallHeading(Directions(), enabled=False))
        self._no_echo_reach = map_config.no_echo_reach
        self._waiting: list[KeyScan] = []  # since a break, with unknown poses in the map
        self._last, self._covariance = Pose2D(), np.zeros((3, 3))  # pose at the last waiting scan, map frame

    def follow(self, key: KeyScan, T_map_local: FloatArray, grid: Grid) -> tuple[FloatArray, list[KeyScan]]:
        """Return ``T_map_local`` (3,) after a key scan, and the key scans whose poses in the map became known."""
        if key.broken and key.index > 0:
            self._waiting, self._last = [], Pose2D.from_array(composed(T_map_local, key.T_local_laser))
            self._covariance = np.diag(BREAK_SIGMAS**2)
        elif not self._waiting:
            return self._tracked(key, T_map_local, grid), [key]
        return self._found(key, T_map_local, grid)

    def restart(self) -> None:
        """Take over a new map, with all key scans in it."""
        self._waiting = []

    def _tracked(self, key: KeyScan, T_map_local: FloatArray, grid: Grid) -> FloatArray:
        """Return the pose of ``local``: a small correction, or the prior if map and scan disagree."""
        prior = composed(T_map_local, key.T_local_laser)
        fit = solve(key.facets, prior, prior, self._information, grid, self._settings)
        if fit.inliers < min(AGREEING[0], AGREEING[1] * key.agreeing_share) * len(key.facets):
            return T_map_local
        return composed_with_inverse(fit.pose, key.T_local_laser)

    def _found(self, key: KeyScan, T_map_local: FloatArray, grid: Grid) -> tuple[FloatArray, list[KeyScan]]:
        """Search the pose of ``local`` around the scan, for all key scans that wait for it."""
        prior = composed(T_map_local, key.T_local_laser)
        last, here = self._last, Pose2D.from_array(prior)
        self._last, self._covariance = here, propagate(self._covariance, last, here)
        self._waiting.append(key)
        scene = Scene(key.facets, key.scan, self._no_echo_reach, grid, self._settings)
        found = self._search.find(scene, prior, self._covariance, last.as_array(), last_agreed=False)
        agrees = found.fit.inliers >= AGREEING[0] * len(key.facets) and not found.contradicted
        if not agrees and len(self._waiting) < MAX_WAITING:
            return T_map_local, []
        known, self._waiting = self._waiting, []
        return composed_with_inverse(found.fit.pose, key.T_local_laser) if agrees else T_map_local, known
