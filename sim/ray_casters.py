"""Ray casters by name: PyBullet's, and a compiled one."""

from collections.abc import Callable
from typing import Final, Protocol

import numpy as np

from sim.plan_grid import cast_in_plan, plan_grid
from sim.world import World
from slam.compiled import compiled
from slam.pose import FloatArray
from slam.scenario.solids import outlines_at


class RayCaster(Protocol):
    """Rays from ``origins`` (N, 2) along the unit vectors ``directions`` (N, 2), all at one height."""

    def cast(self, origins: FloatArray, directions: FloatArray) -> FloatArray:
        """Metres to the nearest surface along each, (N,); inf where none is in reach."""
        ...


class BulletCaster:
    """Rays through the mesh of the world, ``height`` and ``reach`` in metres."""

    def __init__(self, world: World, height: float, reach: float) -> None:
        self._world, self._height, self._reach = world, height, reach

    def cast(self, origins: FloatArray, directions: FloatArray) -> FloatArray:
        return self._reach * self._world.cast(*_both_ends(origins, directions, self._height, self._reach))


class ExactCaster:
    """Rays in the plan of the world, cut at ``height`` metres: a grid of wall segments, walked by compiled code."""

    def __init__(self, world: World, height: float, reach: float) -> None:
        self._grid = plan_grid(outlines_at(world.prisms, height))
        self._reach = reach

    def cast(self, origins: FloatArray, directions: FloatArray) -> FloatArray:
        return cast_in_plan(origins, directions, self._reach, *self._grid)


@compiled
def _both_ends(
    origins: FloatArray, directions: FloatArray, height: float, reach: float
) -> tuple[FloatArray, FloatArray]:
    """Start and end points (N, 3) of rays of this length at this height."""
    starts, ends = np.full((len(origins), 3), height), np.full((len(origins), 3), height)
    for j in range(len(origins)):
        for axis in range(2):
            starts[j, axis] = origins[j, axis]
            ends[j, axis] = origins[j, axis] + reach * directions[j, axis]
    return starts, ends


RAY_CASTERS: Final[dict[str, Callable[[World, float, float], RayCaster]]] = {
    "bullet": BulletCaster,
    "exact": ExactCaster,
}
"""Ray casters by their name in the scenario, made from the world, the height of the rays and their reach, metres."""
