"""The walls of a closed map and their covariances."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from slam.files.graphs.walls import write_walls
from slam.graph.mapped_walls import MappedWalls, mapped_walls
from slam.graph.refined_walls import RefinedWalls
from slam.mapping.surfel_map import SurfelMap
from tests.test_loop_closing import drive

WALL = np.array([[0.0, 0.0], [10.0, 0.0]])
SIGMAS = np.array([0.01, 0.002])


class _Map(SurfelMap):
    """A map of given walls."""

    def __init__(self, walls: np.ndarray) -> None:
        self._walls = walls

    @property
    def ends(self) -> np.ndarray:
        return self._walls


def sigmas_of(wall: np.ndarray) -> np.ndarray:
    """Sigmas of a wall of the map, in a graph with one wall along x."""
    _, run, _ = drive(0.25, "auto")
    assert run is not None
    walls = RefinedWalls(WALL[None], np.zeros((1, 2, 2)), np.zeros(1), np.ones(1, int), np.zeros(1, int))
    run = replace(run, map=_Map(wall[None]), walls=walls, wall_covariances=np.diag(SIGMAS**2)[None])
    return mapped_walls(run).sigmas[0]


def test_a_wall_has_the_covariance_of_the_graph() -> None:
    np.testing.assert_allclose(sigmas_of(WALL), SIGMAS)
    np.testing.assert_allclose(sigmas_of(WALL + np.array([0.0, 0.03])), SIGMAS)


def test_direction_errors_grow_away_from_the_middle() -> None:
    np.testing.assert_allclose(sigmas_of(np.array([[8.0, 0.0], [10.0, 0.0]])), [np.hypot(0.01, 4.0 * 0.002), 0.002])


def test_segments_outside_the_graph_have_no_covariance() -> None:
    for wall in (
        WALL[::-1],
        WALL + np.array([0.0, 0.2]),
        WALL + np.array([20.0, 0.0]),
        np.array([[5.0, 0.0], [5.0, 2.0]]),
    ):
        assert np.isnan(sigmas_of(wall)).all()


def test_without_shared_walls_no_covariance_is_known() -> None:
    _, run, _ = drive(0.25, "auto")
    assert run is not None
    none = RefinedWalls(np.empty((0, 2, 2)), np.empty((0, 2, 2)), np.empty(0), np.empty(0, int), np.empty(0, int))
    found = mapped_walls(replace(run, map=_Map(WALL[None]), walls=none, wall_covariances=np.empty((0, 2, 2))))
    assert found.ends.tolist() == [WALL.tolist()]
    assert np.isnan(found.sigmas).all()


def test_the_file_has_lengths_in_metres_and_nulls(tmp_path: Path) -> None:
    ends = np.stack([WALL, WALL + np.array([0.0, 3.0])])
    write_walls(tmp_path / "walls.geojson", MappedWalls(ends, np.array([SIGMAS, [np.nan, np.nan]])))
    first, second = json.loads((tmp_path / "walls.geojson").read_text())["features"]
    assert first["geometry"] == {"type": "LineString", "coordinates": [[0.0, 0.0], [10.0, 0.0]]}
    assert first["properties"] == {"length": 10.0, "sigma_offset": 0.01, "sigma_direction": 0.002}
    assert second["properties"]["sigma_offset"] is None


def test_most_walls_of_a_drive_are_known() -> None:
    _, run, _ = drive(2.0, "auto")
    assert run is not None
    walls = mapped_walls(run)
    lengths = np.hypot(*(walls.ends[:, 1] - walls.ends[:, 0]).T)
    known = np.isfinite(walls.sigmas[:, 0])
    assert lengths[known].sum() > 0.8 * lengths.sum()
    assert walls.sigmas[known, 0].max() < 0.2
