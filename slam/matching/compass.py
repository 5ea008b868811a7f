"""The walls of a scan as a compass, where the building has main directions: a heading that does not drift."""

from __future__ import annotations

import numpy as np

from slam.lines.segments import Segments
from slam.mapping.directions import Directions
from slam.matching.main_heading import long_walls, turn_to_main
from slam.pose import FloatArray, wrap_angle


class Compass:
    """What the directions of a building say of the heading of the present scan, and what the scan says of them."""

    def __init__(self, directions: Directions, used: bool = True) -> None:
        self.directions, self._used = directions, used
        self._walls = np.empty((0, 3))

    def read(self, segments: Segments) -> None:
        """Take the segments of the present scan, sensor frame."""
        if self._used:
            self._walls = long_walls(segments)

    def steer(
        self, prior: FloatArray, information: FloatArray, heading: float, widest: float
    ) -> tuple[FloatArray, FloatArray]:
        """A prior (3,) of the sensor and its information (3, 3), made better by the main direction that the walls have
        when the sensor turns from ``heading`` by no more than ``widest``, radians; the same where they have none."""
        main = self.directions.main
        if not len(self._walls) or not len(main):
            return prior, information
        turn, variance = turn_to_main(self._walls, main, heading, widest)
        if not np.isfinite(variance):
            return prior, information
        better = information.copy()
        better[2, 2] += 1.0 / variance
        surprise = np.array([0.0, 0.0, wrap_angle(heading + turn - float(prior[2])) / variance])
        return prior + np.linalg.solve(better, surprise), better

    def learn(self, heading: float) -> None:
        """The present scan goes into the map with this heading of the sensor, and its walls into the directions."""
        if len(self._walls):
            theta, variance, length = self._walls.T
            self.directions.learn(theta + heading, variance, length)
