"""The front sonar ring of the P3-DX: eight transducers, each the nearest echo within its cone."""

from collections.abc import Sequence
from math import radians
from typing import Final

import numpy as np

from sim.moving_outlines import MovingOutlines
from sim.ray_casters import Surroundings
from sim.z_buffer import stop_at_legs
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scenario.furniture import Movable
from slam.sonar_ring import FRONT, TRANSDUCERS

REACH: Final = 5.0
"""Longest range, metres."""
HEIGHT: Final = 0.17
"""Height of the ring above the floor, metres; read from pictures of the robot."""
CONE: Final = radians(30.0)
"""Opening angle of a transducer's beam, the usual figure for this ring."""
RAYS: Final = 5
"""Number of rays that sample the beam evenly. Specular reflection at smooth walls is not modelled."""


class SonarRing:
    """Reads the sonar ring against walls, furniture and people's legs; without noise."""

    def __init__(self, surroundings: Surroundings, movables: Sequence[Movable] = ()) -> None:
        self._caster = surroundings.caster("bullet", HEIGHT, REACH)
        self._outlines = MovingOutlines(movables, HEIGHT)
        ring = TRANSDUCERS[:FRONT]
        self._origins = np.repeat(ring[:, :2], RAYS, axis=0)
        self._bearings = (ring[:, 2:] + np.linspace(-CONE / 2.0, CONE / 2.0, RAYS)).ravel()

    def read(
        self, T_map_base: Pose2D, legs: FloatArray, leg_radii: FloatArray, things: FloatArray
    ) -> tuple[float, ...]:
        """Return metres, (8,) from left to right; inf without an echo.

        ``legs`` (L, 2) and ``things`` (M, 3) are the obstacles.
        """
        bearings = self._bearings + T_map_base.theta
        rays = np.vstack([T_map_base.transform(self._origins).T, unit_vectors(bearings).T, bearings])
        ranges = self._caster.cast(rays)
        self._outlines.stop(rays, ranges, things[None], 0.0)
        stop_at_legs(rays, ranges, legs[None], leg_radii, 0.0)
        ranges[ranges > REACH] = np.inf
        return tuple(ranges.reshape(-1, RAYS).min(axis=1).tolist())
