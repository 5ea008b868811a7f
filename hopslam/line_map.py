"""A map of wall segments, as it is now or as it was saved."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np

from hopslam.settings import SettingsLike, slam_config
from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.atomic_files import require_writable
from slam.files.graphs.file import read_graph, write_graph
from slam.files.graphs.key_scans import read_known_graph, write_key_scans
from slam.files.maps.file import read_map, require_cell, required_section, write_map
from slam.graph.known_graph import KnownGraph
from slam.pose import FloatArray, Pose2D
from slam.run.closing_loops import ClosedLoops
from slam.saved_slam import SavedSlam

_NO_POSES = np.empty((0, 3))
_FILE = "map.json"


class Map:
    """Walls, and the path of the robot that mapped them; metres and radians, map frame."""

    def __init__(
        self,
        walls: FloatArray,
        points: FloatArray,
        pose: Pose2D,
        trajectory: FloatArray = _NO_POSES,
        stamps: FloatArray = _NO_POSES[:, 0],
        saved: SavedSlam | None = None,
        closed: ClosedLoops | None = None,
    ) -> None:
        self.walls = walls
        """Start and end of each wall, (N, 2, 2): [wall, start or end, x or y]."""
        self.points = points
        """The map as points, (P, 2)."""
        self.pose = pose
        """Last pose of the robot."""
        self.trajectory = trajectory
        """Pose of the robot at each scan, rows x, y, theta, (K, 3); empty for a map that was loaded."""
        self.stamps = stamps
        """Stamp of each scan, (K,), seconds."""
        self.saved = saved
        """Content of the saved file, in the form of the package ``slam``, which is not part of the stable API."""
        self._closed = closed

    def save(self, folder: str | Path) -> Path:
        """Write the map into a folder, for ``load_map``, ``Slam(saved_map=...)`` and ``hopslam localize --map``.

        Returns the path of its ``map.json``. A run that closed loops also has ``graph.json``, ``key_scans.npz``,
        ``closed.tum`` and ``walls.geojson`` in the folder. InputError in paper mode, which keeps no such map, and if
        the folder cannot be written.
        """
        path = Path(folder)
        if self.saved is None:
            raise InputError(f"{path}: only a map of this project's own method is saved; leave slam.mode=hopslam")
        with require_writable(path, "choose another folder"):
            path.mkdir(parents=True, exist_ok=True)
            if self._closed is None:
                _write(path, self.saved)
            else:
                self._closed.write(path)
        return path / _FILE

    def __repr__(self) -> str:
        length = float(np.hypot(*(self.walls[:, 1] - self.walls[:, 0]).T).sum())
        return f"Map({len(self.walls)} walls, {length:.1f} m in all, {len(self.trajectory)} scans)"

    def picture(self) -> bytes:
        """Draw the walls and the robot's path; return the content of a PNG file."""
        from slam.run.pictures.figure_style import png_of
        from slam.run.pictures.map_picture import MapContents, map_figure

        path = self.trajectory if len(self.trajectory) else self.pose.as_array()[None]
        return png_of(map_figure(MapContents(self.walls, path, points=self.points), longest=9.0))

    def _repr_png_(self) -> bytes:
        return self.picture()


def _write(folder: Path, saved: SavedSlam) -> None:
    """Write a map that was loaded, or whose run continues; an earlier map in the folder is replaced."""
    for other in ("graph.json", "key_scans.npz", "closed.tum", "walls.geojson"):
        (folder / other).unlink(missing_ok=True)
    write_map(folder / _FILE, saved)
    if saved.graph is not None:
        write_key_scans(folder / "key_scans.npz", saved.graph.keys)
        write_graph(folder / "graph.json", saved.graph.graph)


def load_map(path: str | Path, settings: SettingsLike = ()) -> Map:
    """Read a saved map from its folder, a run folder or its ``map.json``.

    The map will be used with these settings. InputError names the file and what is wrong.
    """
    file = Path(path)
    file = file / _FILE if file.is_dir() else file
    config = slam_config(settings)
    saved = read_map(file, config)
    graph, keys = file.with_name("graph.json"), file.with_name("key_scans.npz")
    if config.loops != "never" and graph.is_file() and keys.is_file():
        saved = replace(saved, graph=read_known_graph(keys, read_graph(graph)))
    surfels = saved.mapper.map
    return Map(surfels.ends, surfels.points, saved.T_map_base, saved=saved)


def closed_map(closed: ClosedLoops) -> Map:
    """Make the map of a run whose loops were closed."""
    surfels, saved = closed.run.map, closed.saved
    if saved is not None:
        saved = replace(saved, graph=KnownGraph.of_run(closed.run))
    pose = Pose2D.from_array(closed.trajectory[-1])
    return Map(surfels.ends, surfels.points, pose, closed.trajectory, closed.stamps, saved, closed)


def state_of(given: Map | str | Path, config: SlamConfig) -> SavedSlam:
    """Copy the state from which the method continues in a map; the map itself does not change."""
    if isinstance(given, str | Path):
        given = load_map(given, config)
    if not isinstance(given, Map):
        raise InputError(f"saved_map is of type {type(given).__name__}; give a Map, or the path of one")
    required_section(config, "saved_map")
    if given.saved is None:
        raise InputError("saved_map: a map of paper mode cannot be gone on in; map again with slam.mode=hopslam")
    require_cell(config, given.saved.mapper.map.config.cell, "saved_map")
    saved = deepcopy(given.saved)
    return saved if config.loops != "never" else replace(saved, graph=None)
