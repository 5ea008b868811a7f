"""The uncertainty of the map, place by place: a pose inherits that of the part of the map that it was matched to."""

from math import floor
from typing import Final, NamedTuple

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D

TILE: Final = 2.0
"""Metres: the map within one such square moves as one piece."""
AVERAGED: Final = 13.0
"""Metres and radians of new map that add the variance of one match: it is made by many scans, whose errors average."""
LEFT: Final = 2.0 * TILE
"""Metres from where the map grew last, after which it is left behind."""

Tiles = dict[tuple[int, int], tuple[Pose2D, FloatArray]]
"""Tiles by column and row: the pose at which each was entered first, and the covariance (3, 3) of the map there."""


class Frontier(NamedTuple):
    """The way since a tile was entered for the first time, of which the next new tile inherits the errors."""

    began: Pose2D
    reach: float
    """Greatest distance of the robot from there, metres and radians together."""
    drift: FloatArray
    """Covariance (3, 3) that the matches on the way have left in the map."""
    widest: FloatArray
    """The greatest covariance (3, 3) of a match on the way."""

    def moved(self, pose: Pose2D, match_covariance: FloatArray) -> "Frontier":
        """The frontier after a match at this pose."""
        motion = self.began.between(pose)
        reach = max(self.reach, motion.distance(Pose2D()) + abs(motion.theta))
        drift = self.drift + (reach - self.reach) / AVERAGED * match_covariance
        wider = match_covariance[0, 0] + match_covariance[1, 1] > self.widest[0, 0] + self.widest[1, 1]
        return Frontier(self.began, reach, drift, match_covariance if wider else self.widest)

    def inherited(self, match_covariance: FloatArray) -> FloatArray:
        """Covariance (3, 3) that the map beyond has more than the map here.

        It is the drift, and what later matches were surer of than the widest on the way: they were surer of what was
        mapped since, which is off by as much.
        """
        values, vectors = np.linalg.eigh(self.widest - match_covariance)
        return np.asarray(self.drift + (vectors * np.maximum(values, 0.0)) @ vectors.T)


class MapUncertainty:
    """The covariance that the map had where and when each of its tiles was first entered.

    A scan tells where the robot is in the map; the map itself was made from poses, each matched to what was there
    before. So the error of a pose is that of the tile it is in, carried over from where the tile was entered, and that
    of the match. A robot that comes back to an old tile has no more error than it had there at first.
    """

    def __init__(
        self, tiles: Tiles | None = None, here: tuple[int, int] | None = None, frontier: Frontier | None = None
    ) -> None:
        self.tiles: Tiles = dict(tiles or {})
        self.here, self.frontier = here, frontier

    def nearest_tile(self, pose: Pose2D) -> tuple[int, int] | None:
        """The tile that was entered nearest to a pose; None where there is none."""
        return min(self.tiles, key=lambda tile: self.tiles[tile][0].distance(pose), default=None)

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Enter the tile of a pose, and return the covariance (3, 3) of its x, y, theta in the frame of the first pose.

        ``match_covariance`` (3, 3) is that against the map.
        """
        tile = floor(pose.x / TILE), floor(pose.y / TILE)
        frontier = self.frontier.moved(pose, match_covariance) if self.frontier else None
        new = tile not in self.tiles
        if new:
            entered, covariance = self.tiles[self.here] if self.here else (Pose2D(), np.zeros((3, 3)))
            inherited = frontier.inherited(match_covariance) if frontier else 0.0
            self.tiles[tile] = pose, propagate(covariance, entered, pose) + inherited
        if new or frontier is None or frontier.began.distance(pose) > LEFT:
            frontier = Frontier(pose, 0.0, np.zeros((3, 3)), match_covariance)
        self.frontier = frontier
        self.here = tile
        entered, covariance = self.tiles[tile]
        return propagate(covariance, entered, pose) + match_covariance
