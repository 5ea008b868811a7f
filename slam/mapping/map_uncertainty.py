"""The uncertainty of the map, place by place: a pose inherits that of the part of the map that it was matched to."""

from math import floor
from typing import Final

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D

TILE: Final = 2.0
"""Metres: the map within one such square moves as one piece."""
NEW_TILE_SHARE: Final = 0.15
"""Share of the variance of a match that a new tile adds: its map is made by many scans, whose errors average out."""

Tiles = dict[tuple[int, int], tuple[Pose2D, FloatArray]]
"""Tiles by column and row: the pose at which each was entered first, and the covariance (3, 3) of the map there."""


class MapUncertainty:
    """The covariance that the map had where and when each of its tiles was first entered.

    A scan tells where the robot is in the map; the map itself was made from poses, each matched to what was there
    before. So the error of a pose is that of the tile it is in, carried over from where the tile was entered, and that
    of the match. A robot that comes back to an old tile has no more error than it had there at first.
    """

    def __init__(self, tiles: Tiles | None = None, here: tuple[int, int] | None = None) -> None:
        self.tiles: Tiles = dict(tiles or {})
        self.here = here

    def nearest_tile(self, pose: Pose2D) -> tuple[int, int] | None:
        """The tile that was entered nearest to a pose; None where there is none."""
        return min(self.tiles, key=lambda tile: self.tiles[tile][0].distance(pose), default=None)

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Enter the tile of a pose, and return the covariance (3, 3) of its x, y, theta in the frame of the first pose;
        ``match_covariance`` (3, 3) is that against the map."""
        tile = floor(pose.x / TILE), floor(pose.y / TILE)
        if tile not in self.tiles:
            entered, covariance = self.tiles[self.here] if self.here else (Pose2D(), np.zeros((3, 3)))
            added = NEW_TILE_SHARE * match_covariance if self.tiles else 0.0
            self.tiles[tile] = pose, propagate(covariance, entered, pose) + added
        self.here = tile
        entered, covariance = self.tiles[tile]
        return propagate(covariance, entered, pose) + match_covariance
