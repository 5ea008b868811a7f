"""A map on the disk: ``map.json``, a text of plain numbers that are read back exactly.

The format is JSON: people, and programs in every language, can read it, and it contains no code. Each surfel has a
line, so that two maps can be compared line by line.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from slam.config import SlamConfig, SurfelMapConfig
from slam.errors import InputError
from slam.files.atomic_files import write_atomic
from slam.files.json_files import read_bounded
from slam.files.maps.schema import VERSION, MapDocument, SavedFrontier, SavedGrid
from slam.lines.learnt_noise import LearntNoise
from slam.mapping.directions import Directions
from slam.mapping.map_uncertainty import Frontier, MapUncertainty
from slam.mapping.surfel_grid import ALIVE, BORN, COLUMNS, FREE, HITS, TAKEN, Grid
from slam.mapping.surfel_map import SurfelMap
from slam.mapping.wall_evidence import evidence_of_hits
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.pose import Pose2D
from slam.saved_slam import SavedSlam
from slam.scenario.validation_message import error_message


def write_map(path: Path, saved: SavedSlam) -> None:
    """Write the file at once or not at all."""
    state, directions = saved.mapper, saved.mapper.directions
    robot = {
        "T_map_base": _row(saved.T_map_base),
        "T_odom_base": _row(saved.T_odom_base),
        "T_map_mapped": _row(saved.T_map_mapped),
        "T_map_matched": _row(state.T_map_base),
        "T_map_added": _row(state.T_map_added),
        "covariance": state.covariance.tolist(),
        "growth": state.odometry_inflation,
        "misfits": state.bad_matches,
        "excess": state.odometry_excess.tolist(),
        "stamp": state.stamp,
        "tile": state.uncertainty.here,
        "frontier": _frontier_row(state.uncertainty.frontier),
    }
    tiles = [
        {"tile": tile, "entered": _row(pose), "covariance": covariance.tolist()}
        for tile, (pose, covariance) in state.uncertainty.tiles.items()
    ]
    parts = {
        "format": json.dumps("hopslam map"),
        "version": str(VERSION),
        "robot": json.dumps(robot),
        "tiles": _lines(tiles),
        "directions": json.dumps({"total": directions.total, "clusters": directions.clusters.tolist()}),
        "noise": json.dumps({"differences": saved.noise.counts.tolist()}),
        "grid": _grid_text(state.map.grid),
    }
    write_atomic(path, "{\n" + ",\n".join(f'"{key}": {text}' for key, text in parts.items()) + "\n}\n")


def read_map(path: Path, config: SlamConfig) -> SavedSlam:
    """Read the map, to be used with these settings. InputError names the file, the key and what is wrong."""
    section = required_section(config, path)
    document = _parse(path)
    require_cell(config, document.grid.cell, path)
    robot = document.robot
    tiles = {saved.tile: (Pose2D(*saved.entered), np.array(saved.covariance)) for saved in document.tiles}
    state = SurfelMapperState(
        SurfelMap(section, _grid(document.grid)),
        MapUncertainty(tiles, robot.tile, _frontier(robot.frontier)),
        _pose(robot.T_map_matched),
        _pose(robot.T_map_added),
        np.array(robot.covariance),
        robot.growth,
        robot.misfits,
        np.array(robot.excess),
        Directions(np.array(document.directions.clusters).reshape(-1, 3), document.directions.total),
        robot.stamp,
    )
    differences = document.noise.differences
    noise = LearntNoise(np.array(differences)) if differences else LearntNoise.start(config.lines)
    return SavedSlam(state, Pose2D(*robot.T_map_base), _pose(robot.T_odom_base), _pose(robot.T_map_mapped), noise)


def required_section(config: SlamConfig, name: object) -> SurfelMapConfig:
    """Return the settings of the map; InputError for a method that cannot use a saved map, such as the paper's."""
    if not isinstance(config.map, SurfelMapConfig):
        raise InputError(
            f"{name}: a saved map needs slam.mode=hopslam; these settings have slam.map.method=points; "
            "take those of another scenario, for a log with --scenario replay"
        )
    if config.matching.method != "least_squares":
        raise InputError(f"{name}: a saved map is matched by least_squares; leave slam.matching.method out")
    return config.map


def require_cell(config: SlamConfig, cell: float, name: object) -> None:
    """Require settings with cells of the size, metres, that this map has."""
    expected = required_section(config, name).cell
    if cell != expected:
        cells = f"has cells of {cell:g} m, the settings {expected:g} m"
        raise InputError(f"{name}: grid.cell: the map {cells}; add --set slam.map.cell={cell:g}")


def _parse(path: Path) -> MapDocument:
    try:
        return MapDocument.model_validate_json(read_bounded(path))
    except ValidationError as errors:
        raise InputError(f"{path}: {_validation_message(errors)}") from errors
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}; give the map.json of a run folder") from error


def _validation_message(errors: ValidationError) -> str:
    """Return the first wrong key, but a wrong version before all others."""
    error = min(errors.errors(), key=lambda error: error["loc"] != ("version",))
    if error["loc"] == ("version",) and error["type"] != "missing":
        return f"version: this hopslam reads version {VERSION}, and not {error['input']!r}; map again, or update"
    location, reason = error_message(error, MapDocument)
    key = ".".join(map(str, location)) or "the whole"
    return f"{key}: {reason}; a map is written by hopslam run and replay as map.json"


def _grid_text(grid: Grid) -> str:
    taken = int(grid.counts[TAKEN])
    rows, columns = np.nonzero(grid.head >= 0)
    cells = np.column_stack([rows + grid.corner[0], columns + grid.corner[1], grid.head[rows, columns]]).tolist()
    surfels = [
        [*surfel, following]
        for surfel, following in zip(grid.surfels[:taken, :BORN].tolist(), grid.next[:taken].tolist(), strict=True)
    ]
    parts: dict[str, str] = {
        "cell": json.dumps(grid.cell),
        "corner": json.dumps(grid.corner.tolist()),
        "shape": json.dumps(grid.head.shape),
        "free": json.dumps(int(grid.counts[FREE])),
        "cells": _lines(cells),
        "surfels": _lines(surfels),
        "evidence": _lines(grid.evidence[:taken].tolist()),
        "way": json.dumps(grid.path_length),
        "born": json.dumps(grid.surfels[:taken, BORN].tolist()),
    }
    return "{\n" + ",\n".join(f'"{key}": {text}' for key, text in parts.items()) + "\n}"


def _lines(items: list[Any]) -> str:
    """Format a list with a line for each item."""
    return "[\n" + ",\n".join(map(json.dumps, items)) + "\n]"


def _grid(saved: SavedGrid) -> Grid:
    """Make the grid, without spare room: it grows when surfels are added."""
    count = len(saved.surfels)
    table = np.array(saved.surfels, np.float64).reshape(count, BORN + 1)
    surfels = np.zeros((count, COLUMNS))
    surfels[:, :BORN] = table[:, :BORN]
    surfels[:, BORN] = saved.born or -1.0
    head = np.full(saved.shape, -1, np.int32)
    corner = np.array(saved.corner, np.int64)
    cells = np.array(saved.cells, np.int64).reshape(-1, 3)
    head[cells[:, 0] - corner[0], cells[:, 1] - corner[1]] = cells[:, 2]
    counts = np.empty(3, np.int64)
    counts[TAKEN], counts[FREE], counts[ALIVE] = count, saved.free, (table[:, HITS] > 0.0).sum()
    return Grid(
        head=head,
        next=table[:, BORN].astype(np.int32),
        surfels=surfels,
        evidence=np.array(saved.evidence, np.int8) if saved.evidence else evidence_of_hits(surfels),
        corner=corner,
        cell=saved.cell,
        counts=counts,
        path_length=saved.way,
    )


def _frontier_row(frontier: Frontier | None) -> dict[str, Any] | None:
    if frontier is None:
        return None
    began, reach, drift, widest = frontier
    return {"began": _row(began), "reach": reach, "drift": drift.tolist(), "widest": widest.tolist()}


def _frontier(saved: SavedFrontier | None) -> Frontier | None:
    if saved is None:
        return None
    return Frontier(Pose2D(*saved.began), saved.reach, np.array(saved.drift), np.array(saved.widest))


def _row(pose: Pose2D | None) -> list[float] | None:
    return None if pose is None else pose.as_array().tolist()


def _pose(row: tuple[float, float, float] | None) -> Pose2D | None:
    return None if row is None else Pose2D(*row)
