"""State of the mapper in the map of a closed run, for continued mapping or localisation."""

from dataclasses import replace
from math import floor

import numpy as np

from slam.graph.closure import ClosedRun
from slam.mapping.directions import LENGTH, THETA, Directions
from slam.mapping.map_uncertainty import TILE, MapUncertainty, Tiles
from slam.mapping.surfel_map import SurfelMap
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.matching.wall_heading import MIN_LENGTH
from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D


def placed(
    state: SurfelMapperState, T_map_local: Pose2D, surfel_map: SurfelMap, uncertainty: MapUncertainty
) -> SurfelMapperState:
    """Transform a state from the frame ``local`` to the frame of this map."""
    T_map_base, T_map_added = (
        None if pose is None else T_map_local @ pose for pose in (state.T_map_base, state.T_map_added)
    )
    here = None if T_map_base is None else uncertainty.nearest_tile(T_map_base)
    return replace(
        state,
        map=surfel_map,
        uncertainty=MapUncertainty(uncertainty.tiles, here),
        T_map_base=T_map_base,
        T_map_added=T_map_added,
        covariance=_turned(state.covariance, T_map_local),
        directions=directions_of(surfel_map),
    )


def uncertainty_of(closed: ClosedRun) -> MapUncertainty:
    """Return the uncertainty of the map, tile by tile: the covariance of the first key scan in the tile."""
    tiles: Tiles = {}
    T_laser_base = Pose2D.from_array(closed.T_base_laser).inverse()
    for pose, covariance in zip(closed.poses, closed.covariances, strict=True):
        T_map_laser = Pose2D.from_array(pose)
        T_map_base = T_map_laser @ T_laser_base
        tile = floor(T_map_base.x / TILE), floor(T_map_base.y / TILE)
        if tile not in tiles:
            tiles[tile] = T_map_base, propagate(covariance, T_map_laser, T_map_base)
    return MapUncertainty(tiles)


def directions_of(surfel_map: SurfelMap) -> Directions:
    """Return the directions of the long walls of a map."""
    along = surfel_map.ends[:, 1] - surfel_map.ends[:, 0]
    walls = np.zeros((len(along), 3))
    walls[:, THETA], walls[:, LENGTH] = np.arctan2(along[:, 1], along[:, 0]), np.hypot(along[:, 0], along[:, 1])
    directions = Directions()
    directions.add(walls[walls[:, LENGTH] >= MIN_LENGTH])
    return directions


def _turned(covariance: FloatArray, T_map_local: Pose2D) -> FloatArray:
    """Transform a covariance (3, 3) of a pose from the axes of ``local`` to those of the map."""
    R = np.eye(3)
    R[:2, :2] = T_map_local.rotation
    return np.asarray(R @ covariance @ R.T)
