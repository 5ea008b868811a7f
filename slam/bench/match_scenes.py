"""Scans on which matchers are compared: one world, scans at known poses that make the map, and scans to match to it."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from slam.bench.floor_plans import cast_beams
from slam.lidars import URG04LX
from slam.pose import Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Scenario
from slam.scenario.solids import clearance, obstacle_footprints, sample_path

FAN: Final = 682 * URG04LX.lidar.angle_increment
"""Field of view, radians, for any number of beams."""
NOISE: Final = 1 / 3
"""Standard deviation of the ranges as a share of the maker's bound."""
SPACING: Final = 0.5
"""Metres between the scans of the map; two of opposite heading at each place."""
REACH: Final = 4.0
FIXED_SHARE: Final = 0.05
"""Smallest eigenvalue, above which a pose is constrained, of the mean outer product of the walls' directions over all
beams: it is 0 if all walls are parallel, and 0.5 if there are as many of one direction as across it."""


@dataclass(frozen=True, slots=True)
class PlacedScan:
    """A scan, and the pose of the laser at which it was taken."""

    scan: LaserScan
    T_map_laser: Pose2D


class ScannedWorld:
    """Plan of a scenario's world, scanned by a lidar with any number of beams; one seed decides all random numbers."""

    def __init__(self, scenario: Scenario, seed: int) -> None:
        outlines = scenario.world.outlines(scenario.lidar.height)
        ends = [np.stack([outline, np.roll(outline, -1, axis=0)], axis=1) for outline in outlines]
        self._walls = np.concatenate(ends)
        self._solids = obstacle_footprints(scenario.world.prisms())
        self._route = [(scenario.robot.start.x, scenario.robot.start.y), *scenario.route.waypoints]
        self._random = np.random.default_rng(seed)

    def map_scans(self) -> list[PlacedScan]:
        """Scans along the route, in both directions."""
        scans = []
        for (x0, y0), (x1, y1) in pairwise(self._route):
            heading = float(np.arctan2(y1 - y0, x1 - x0))
            for x, y in sample_path([(x0, y0), (x1, y1)], SPACING).tolist():
                scans += [self.scan(Pose2D(x, y, heading + turn), 682) for turn in (0.0, np.pi)]
        return scans

    def places(self, count: int) -> list[Pose2D]:
        """Draw free poses near the route from which walls constrain the lidar's position in every direction."""
        samples, found = sample_path(self._route), list[Pose2D]()
        while len(found) < count:
            place = samples[self._random.integers(len(samples))] + self._random.uniform(-0.5, 0.5, 2)
            pose = Pose2D(float(place[0]), float(place[1]), float(self._random.uniform(-np.pi, np.pi)))
            if clearance(place[np.newaxis], self._solids)[0] > 0.3 and self._fixes(pose):
                found.append(pose)
        return found

    def scan(self, T_map_laser: Pose2D, beams: int) -> PlacedScan:
        """Make a scan with this number of beams, always in the same field of view."""
        increment = FAN / beams
        angles = -0.5 * FAN + increment * (np.arange(beams) + 0.5)
        distance, _ = cast_beams(self._walls, T_map_laser, angles)
        seen = distance < REACH
        sigma = NOISE * URG04LX.accuracy(np.where(seen, distance, 0.0))
        ranges = np.where(seen, distance + sigma * self._random.standard_normal(beams), np.inf)
        return PlacedScan(LaserScan(0.0, float(angles[0]), increment, 0.06, 4.095, ranges), T_map_laser)

    def _fixes(self, T_map_laser: Pose2D) -> bool:
        distance, wall = cast_beams(self._walls, T_map_laser, np.linspace(-0.5 * FAN, 0.5 * FAN, 200))
        along = np.diff(self._walls[wall[distance < REACH]], axis=1)[:, 0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        return len(along) > 50 and bool(np.linalg.eigvalsh(along.T @ along / len(along))[0] > FIXED_SHARE)
