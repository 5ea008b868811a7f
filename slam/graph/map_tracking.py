"""Key scans matched to the whole map, so that what was seen long ago holds the robot before the next loop is closed."""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig
from slam.graph.key_scan import KeyScan
from slam.graph.single_poses import composed, undone
from slam.mapping.surfel_grid import Grid
from slam.matching.least_squares import SolverSettings, solve
from slam.pose import FloatArray

SIGMAS: Final = np.array([0.02, 0.02, 0.0005])
"""Metres and radians by which the frame ``local`` may drift in the map between key scans. Its heading drifts
little: the walls of the submap hold it, and the main directions of the building."""
AGREEING: Final = 0.5, 0.8
"""Share of the facets that must agree with the map, and share of that with which the scan agreed with its own submap:
the lesser."""


class MapTracking:
    """Follows the frame ``local`` in the map from key scan to key scan."""

    def __init__(self, config: LeastSquaresConfig) -> None:
        shared = {name: getattr(config, name) for name in SolverSettings._fields if name != "standing_way"}
        self._settings = SolverSettings(**shared, standing_way=0.0)
        self._information = np.diag(SIGMAS**-2.0)

    def T_map_local(self, key: KeyScan, T_map_local: FloatArray, grid: Grid) -> FloatArray:
        """Return the pose of ``local`` in the map (3,) by a key scan; where they disagree, ``T_map_local`` as it is."""
        prior = composed(T_map_local, key.T_local_laser)
        fit = solve(key.facets, prior, prior, self._information, grid, self._settings)
        if fit.inliers < min(AGREEING[0], AGREEING[1] * key.share) * len(key.facets):
            return T_map_local
        return undone(fit.pose, key.T_local_laser)
