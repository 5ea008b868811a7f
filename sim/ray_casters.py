"""Ray casters by name: PyBullet's, and a compiled one."""

from collections.abc import Callable
from typing import Final, Protocol

import numpy as np

from sim.wall_plan import wall_plan
from sim.world import World
from sim.z_buffer import stop_at_walls
from slam.pose import FloatArray
from slam.scenario.solids import outlines_at


class RayCaster(Protocol):
    """Rays (5, N) as in ``sim/rays.py``, all at one height."""

    def cast(self, rays: FloatArray) -> FloatArray:
        """Metres to the nearest surface along each, (N,); inf where none is in reach."""
        ...


class BulletCaster:
    """Rays through the mesh of the world, ``height`` and ``reach`` in metres."""

    def __init__(self, world: World, height: float, reach: float) -> None:
        self._world, self._height, self._reach = world, height, reach

    def cast(self, rays: FloatArray) -> FloatArray:
        starts = np.column_stack([rays[0], rays[1], np.full(rays.shape[1], self._height)])
        ends = starts.copy()
        ends[:, :2] += self._reach * rays[2:4].T
        return self._reach * self._world.cast(starts, ends)


class ExactCaster:
    """Rays in the plan of the world, cut at ``height`` metres, by an interval z-buffer."""

    def __init__(self, world: World, height: float, reach: float) -> None:
        self._plan = wall_plan([outlines_at(world.prisms, height)], reach)

    def cast(self, rays: FloatArray) -> FloatArray:
        ranges = np.full(rays.shape[1], np.inf)
        stop_at_walls(rays, ranges, self._plan, 0)
        ranges[ranges > self._plan.reach] = np.inf
        return ranges


RAY_CASTERS: Final[dict[str, Callable[[World, float, float], RayCaster]]] = {
    "bullet": BulletCaster,
    "exact": ExactCaster,
}
"""Ray casters by their name in the scenario, made from the world, the height of the rays and their reach, metres."""
