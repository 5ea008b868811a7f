"""The uncertainty of the map, place by place: a pose inherits that of the part of the map that it was matched to."""

from math import floor
from typing import Final, NamedTuple

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D

TILE: Final = 2.0
"""Side of a square of the map, metres, that moves as one piece."""
AVERAGED: Final = 13.0
"""Length of a path into a new area, metres and radians, over which the variance of the map grows by that of one match.
It grows so slowly because the map is made of many scans, whose errors average."""
END_DISTANCE: Final = 2.0 * TILE
"""Distance from the last growth of the map, metres, beyond which the frontier ends."""

Tiles = dict[tuple[int, int], tuple[Pose2D, FloatArray]]
"""Tiles by column and row: the pose at which each was entered first, and the covariance (3, 3) of the map there."""


class Frontier(NamedTuple):
    """The path since a tile was entered for the first time; the next new tile inherits its errors."""

    began: Pose2D
    reach: float
    """Greatest distance of the robot from its start, the sum of metres and radians."""
    drift: FloatArray
    """Covariance (3, 3) that the matches on the path have left in the map."""
    widest: FloatArray
    """The greatest covariance (3, 3) of a match on the path."""

    def moved(self, pose: Pose2D, match_covariance: FloatArray) -> "Frontier":
        """Return the frontier after a match at this pose."""
        motion = self.began.between(pose)
        reach = max(self.reach, motion.distance(Pose2D()) + abs(motion.theta))
        drift = self.drift + (reach - self.reach) / AVERAGED * match_covariance
        wider = match_covariance[0, 0] + match_covariance[1, 1] > self.widest[0, 0] + self.widest[1, 1]
        return Frontier(self.began, reach, drift, match_covariance if wider else self.widest)

    def inherited(self, match_covariance: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) that the map beyond the frontier has in addition to the map here.

        It is the drift, plus the excess of the least accurate match on the path over this one. That match left its
        error in the map, and a more accurate match to this map does not remove it.
        """
        values, vectors = np.linalg.eigh(self.widest - match_covariance)
        return np.asarray(self.drift + (vectors * np.maximum(values, 0.0)) @ vectors.T)


class MapUncertainty:
    """The covariance of the map in each tile, at the time and pose of its first entry.

    A scan measures the robot's pose in the map; the map itself was made from poses, each matched to the earlier map. So
    the error of a pose is that of its tile, transformed from the first entry of the tile, plus that of the match. A
    robot that returns to an old tile has no more error than it had there at first.
    """

    def __init__(
        self, tiles: Tiles | None = None, here: tuple[int, int] | None = None, frontier: Frontier | None = None
    ) -> None:
        self.tiles: Tiles = dict(tiles or {})
        self.here, self.frontier = here, frontier

    def nearest_tile(self, pose: Pose2D) -> tuple[int, int] | None:
        """Return the tile with the nearest entry to a pose; None if there is none."""
        return min(self.tiles, key=lambda tile: self.tiles[tile][0].distance(pose), default=None)

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Enter the tile of a pose, and return the covariance (3, 3) of its x, y, theta in the frame of the first pose.

        ``match_covariance`` (3, 3) is that of the match to the map.
        """
        tile = floor(pose.x / TILE), floor(pose.y / TILE)
        frontier = self.frontier.moved(pose, match_covariance) if self.frontier else None
        new = tile not in self.tiles
        if new:
            entered, covariance = self.tiles[self.here] if self.here else (Pose2D(), np.zeros((3, 3)))
            inherited = frontier.inherited(match_covariance) if frontier else 0.0
            self.tiles[tile] = pose, propagate(covariance, entered, pose) + inherited
        if new or frontier is None or frontier.began.distance(pose) > END_DISTANCE:
            frontier = Frontier(pose, 0.0, np.zeros((3, 3)), match_covariance)
        self.frontier = frontier
        self.here = tile
        entered, covariance = self.tiles[tile]
        return propagate(covariance, entered, pose) + match_covariance
