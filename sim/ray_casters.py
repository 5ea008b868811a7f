"""Ray casters, which return the ranges of rays to the lidar and the sonar."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from sim.wall_plan import wall_plan
from sim.z_buffer import stop_at_walls
from slam.pose import FloatArray
from slam.scenario.lidar_config import CasterName
from slam.scenario.solids import Prism, outlines_at


class RayCaster(Protocol):
    """Rays (5, N) as in ``sim/rays.py``, all at one height."""

    def cast(self, rays: FloatArray) -> FloatArray:
        """Return the metres to the nearest surface along each ray, (N,); inf if none is in range."""
        ...


class Surroundings(Protocol):
    """Walls and things around the sensors."""

    def caster(self, name: CasterName, height: float, reach: float) -> RayCaster:
        """Make the ray caster with this name, or the only available one, for rays at this height and of this length."""
        ...


class ExactCaster:
    """Casts rays in the plan of these solids, cut at ``height`` metres, by an interval z-buffer."""

    def __init__(self, prisms: Sequence[Prism], height: float, reach: float) -> None:
        self._plan = wall_plan([outlines_at(prisms, height)], reach)

    def cast(self, rays: FloatArray) -> FloatArray:
        ranges = np.full(rays.shape[1], np.inf)
        stop_at_walls(rays, ranges, self._plan, 0)
        ranges[ranges > self._plan.reach] = np.inf
        return ranges
