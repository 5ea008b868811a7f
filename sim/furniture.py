"""Furniture that the robot can push: bodies in the simulated world, and outlines that stop the lidar's rays."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2

import numpy as np

from sim.bullet import pybullet
from sim.movable import add_movable
from sim.rays import stop_at_outlines
from sim.world import World
from slam.pose import FloatArray
from slam.scenario.furniture import Movable


class Furniture:
    """Upright bodies that slide and turn on the floor, and never tip over."""

    def __init__(self, world: World, movables: Sequence[Movable]) -> None:
        self._world = world
        self._bodies = [add_movable(world, thing) for thing in movables]
        self._find = [world.bullet.prepared(pybullet.getBasePositionAndOrientation, body) for body in self._bodies]

    def leave(self) -> None:
        """Put all of it far from everything and from each other: see ``P3dx.leave``."""
        for number, body in enumerate(self._bodies):
            self._world.send_away(body, number + 1)

    @property
    def places(self) -> FloatArray:
        """Present poses: x, y, theta in the map frame, (M, 3); metres, radians."""
        places = [(x, y, 2.0 * atan2(qz, qw)) for (x, y, _), (_, _, qz, qw) in (find() for find in self._find)]
        return np.array(places, np.float64).reshape(-1, 3)


class MovingOutlines:
    """Outlines of things that move, in a horizontal plane at ``height`` metres."""

    def __init__(self, movables: Sequence[Movable], height: float) -> None:
        ends = [
            np.insert(np.hstack([p.footprint, np.roll(p.footprint, -1, axis=0) - p.footprint]), 0, owner, axis=1)
            for owner, thing in enumerate(movables)
            for p in thing.prisms
            if p.bottom <= height <= p.top
        ]
        self._segments = np.concatenate([np.empty((0, 5)), *ends])
        """(K, 5): the number of the thing; x, y of one end in its frame, and from there to the other."""

    def stop(
        self, origins: FloatArray, directions: FloatArray, ranges: FloatArray, places: FloatArray, steps: float
    ) -> None:
        """Shorten ``ranges`` (N,) in place where an outline stands in the way of a ray when it fires.

        ``places`` (C, M, 3) are x, y and theta of the things; from one ray to the next, ``steps`` rows pass.
        """
        if len(self._segments):
            stop_at_outlines(origins, directions, ranges, places, self._segments, steps)
