"""State of this project's matcher and map, for saving and continuing."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from slam.config import SurfelMapConfig
from slam.mapping.directions import Directions
from slam.mapping.map_uncertainty import MapUncertainty
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class SurfelMapperState:
    """State of SurfelMapper, without its settings.

    Map, uncertainty and directions are shared with it, and change while it runs.
    """

    map: SurfelMap
    uncertainty: MapUncertainty
    T_map_base: Pose2D | None
    """Pose of the base after the last match; None before the first scan."""
    T_map_added: Pose2D | None
    """Pose of the laser when the last scan was added to the map."""
    covariance: FloatArray
    """Covariance (3, 3) of ``T_map_base`` against the map; m^2, m rad and rad^2."""
    odometry_inflation: float = 1.0
    """Factor on the variances of odometry, which grows when scans contradict it."""
    bad_matches: int = 0
    """Number of consecutive scans that did not fit the map."""
    odometry_excess: FloatArray = field(default_factory=lambda: np.zeros(2))
    """Variances of the errors of odometry beyond its model, m^2 and rad^2: see motion_model."""
    directions: Directions = field(default_factory=Directions)
    """Directions of the building's walls."""
    stamp: float | None = None
    """Time of the last scan, seconds; None before the first, and for a restarted robot."""

    @classmethod
    def empty(cls, config: SurfelMapConfig) -> Self:
        """The state before the first scan."""
        return cls(SurfelMap(config), MapUncertainty(), None, None, np.zeros((3, 3)))

    def relocated(self, T_map_base: Pose2D, covariance: FloatArray) -> Self:
        """Return the same map with a robot that restarts at this pose, with this covariance (3, 3)."""
        uncertainty = MapUncertainty(self.uncertainty.tiles, self.uncertainty.nearest_tile(T_map_base))
        return replace(
            self, uncertainty=uncertainty, T_map_base=T_map_base, T_map_added=None, covariance=covariance,
            odometry_inflation=1.0, bad_matches=0, odometry_excess=np.zeros(2), stamp=None,
        )  # fmt: skip
