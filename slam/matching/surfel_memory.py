"""All that this project's matcher and map know, apart from their settings: what is saved, and continued from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from slam.config import SurfelMapConfig
from slam.mapping.directions import Directions
from slam.mapping.drift import Drift
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class SurfelMemory:
    """The map, and where the robot stood in it."""

    map: SurfelMap
    drift: Drift
    T_map_base: Pose2D | None
    """After the last match; None before the first scan."""
    T_map_added: Pose2D | None
    """Of the laser, with the last scan that went into the map."""
    covariance: FloatArray
    """Of the base at ``T_map_base`` against the map, (3, 3); m^2, m rad and rad^2."""
    growth: float = 1.0
    """What the variances of odometry are multiplied by, for it was contradicted so."""
    misfits: int = 0
    """Scans in a row that did not fit."""
    directions: Directions = field(default_factory=Directions)
    """That the walls of the building have, and main ones among them; shared as the map is."""

    @classmethod
    def empty(cls, config: SurfelMapConfig) -> Self:
        """Nothing is known."""
        return cls(SurfelMap(config), Drift(), None, None, np.zeros((3, 3)))

    def standing(self, T_map_base: Pose2D, covariance: FloatArray) -> Self:
        """The same map, with a robot that was set down elsewhere and is so unsure (3, 3) of it. The map is shared."""
        drift = Drift(self.drift.tiles, self.drift.nearest(T_map_base))
        return replace(
            self, drift=drift, T_map_base=T_map_base, T_map_added=None, covariance=covariance, growth=1.0, misfits=0
        )
