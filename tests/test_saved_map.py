"""Maps that are saved and continued."""

import json
from collections.abc import Callable
from math import sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.maps.file import read_map, write_map
from slam.line_slam import Estimate, LineSlam
from slam.lines.learnt_noise import LearntNoise
from slam.mapping.surfel_grid import BORN
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.saved_slam import relocate, resume, save
from slam.scan import LaserScan

PATH = [Pose2D(0.05 * k, 0.3 * sin(0.1 * k), 0.02 * k) for k in range(60)]
MOUNT = Pose2D(0.1, 0.0, 0.02)
Update = Callable[[LineSlam, int], Estimate]


@pytest.fixture(scope="module")
def update(scan_of: Callable[..., LaserScan], room: FloatArray) -> Update:
    """Updates a SLAM with the scan of a number; the odometry is 5 % too long."""

    def updated(slam: LineSlam, k: int) -> Estimate:
        wheels = Pose2D(1.05 * PATH[k].x, 1.05 * PATH[k].y, PATH[k].theta)
        return slam.update(scan_of(room, PATH[k] @ MOUNT, k), Odometry(0.1 * k, wheels))

    return updated


def save_to(slam: LineSlam, path: Path) -> Path:
    saved = save(slam)
    assert saved is not None
    write_map(path, saved)
    return path


IN_ONE_MAP = SlamConfig(loops="never")


@pytest.fixture
def half(update: Update, tmp_path: Path) -> tuple[LineSlam, Path]:
    """A run half done, and its map."""
    slam = LineSlam(IN_ONE_MAP, MOUNT)
    for k in range(30):
        update(slam, k)
    return slam, save_to(slam, tmp_path / "map.json")


def test_a_continued_run_is_bit_for_bit_the_same(half: tuple[LineSlam, Path], update: Update) -> None:
    slam, path = half
    again = resume(SlamConfig(), MOUNT, read_map(path, SlamConfig()))
    for k in range(30, 60):
        one, other = update(slam, k), update(again, k)
        assert one.T_map_base == other.T_map_base
        assert np.array_equal(one.covariance, other.covariance)
    assert save_to(slam, path.with_name("a")).read_text() == save_to(again, path.with_name("b")).read_text()
    assert np.array_equal(slam.lines.ends, again.lines.ends)


def test_a_saved_map_is_read_back_unchanged(half: tuple[LineSlam, Path]) -> None:
    _, path = half
    write_map(path.with_name("again"), read_map(path, SlamConfig()))
    assert path.with_name("again").read_text() == path.read_text()


def test_surfels_of_an_older_file_count_as_old(half: tuple[LineSlam, Path]) -> None:
    _, path = half
    document = json.loads(path.read_text())
    assert max(document["grid"].pop("born")) > 1.0
    del document["grid"]["way"]
    path.write_text(json.dumps(document))
    assert (read_map(path, SlamConfig()).mapper.map.surfels[:, BORN] <= -1.0).all()


def test_walls_of_an_older_file_come_from_its_surfels(half: tuple[LineSlam, Path]) -> None:
    path, document = half[1], json.loads(half[1].read_text())
    saved = read_map(path, SlamConfig()).mapper.map
    np.testing.assert_array_equal(saved.ends, half[0].lines.ends)
    del document["grid"]["evidence"]
    path.write_text(json.dumps(document))
    read = read_map(path, SlamConfig()).mapper.map
    length, before = (np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum() for ends in (read.ends, saved.ends))
    assert 0.8 * before < length < 1.3 * before


def test_a_map_without_learned_noise_starts_from_the_default(half: tuple[LineSlam, Path]) -> None:
    slam, path = half
    assert read_map(path, SlamConfig()).noise.noise == slam.noise.noise
    document = json.loads(path.read_text())
    del document["noise"]
    path.write_text(json.dumps(document))
    assert read_map(path, SlamConfig()).noise.noise == LearntNoise.start().noise


def test_mapping_continues_from_another_place(half: tuple[LineSlam, Path], update: Update) -> None:
    _, path = half
    slam = relocate(SlamConfig(), MOUNT, read_map(path, SlamConfig()), PATH[40] @ Pose2D(0.05, 0.05, 0.03))
    before = len(slam.points)
    estimates = [update(slam, k) for k in range(40, 60)]
    assert estimates[-1].T_map_base.distance(PATH[59]) < 0.03
    assert len(slam.points) < 1.2 * before


def test_a_map_of_paper_mode_is_not_saved() -> None:
    assert save(LineSlam(SlamConfig(mode="paper"), Pose2D())) is None


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("version", 2, "version: this hopslam reads version 1, and not 2"),
        ("format", "pgm", "format: "),
        ("grid.cell", 0.1, "grid.cell|lies? in its cell"),
        ("grid.free", 5, "grid: the list of free places leads to surfel 5"),
        ("grid.shape", [3, 3], r"grid: cell \(.*\) lies outside"),
        ("grid.shape", [100000, 100000], "10,000,000,000 cells in its shape, over the limit"),
        ("grid.surfels.0.7", 0, "which is not its own"),
        ("grid.surfels.0.7", 10**6, "which is not its own"),
        ("grid.surfels.0.2", 3.0, "has a normal whose length is not 1"),
        ("grid.surfels.0.0", float("inf"), "grid.surfels.0.0: "),
        ("grid.surfels.0.4", -1.0, "information above 0"),
        ("grid.born", [1.0], "grid: born has 1 numbers, for"),
        ("grid.evidence", [[0] * 9], "grid: evidence has 1 rows, for"),
        ("grid.evidence.0.0", 200, "grid.evidence.0.0: "),
        ("grid.cells", [], "is not in any list"),
        ("robot.covariance.0.0", -1.0, "robot: covariance"),
        ("robot.tile", [99, 99], "is not one of the tiles"),
        ("robot.wheels", 2, "robot.wheels: "),
        ("noise.differences", [[0.0] * 36], "has 1 bands of range, not 18"),
        ("noise.differences.0.0", -1.0, "noise.differences.0.0: "),
        ("directions.total", -1.0, "directions.total: "),
        ("directions.clusters.0.0", 2.0, "directions.clusters.0.0: "),
        ("directions.clusters", [[0.0, 1.0, 0.0]] * 17, "directions.clusters: "),
    ],
)
def test_a_damaged_map_is_refused(half: tuple[LineSlam, Path], key: str, value: Any, complaint: str) -> None:
    _, path = half
    document = json.loads(path.read_text())
    *way, last = (int(step) if step.isdigit() else step for step in key.split("."))
    at = document
    for step in way:
        at = at[step]
    at[last] = value
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=complaint) as error:
        read_map(path, SlamConfig())
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_map_without_main_directions_is_read(half: tuple[LineSlam, Path]) -> None:
    _, path = half
    document = json.loads(path.read_text())
    assert document.pop("directions")["total"] > 0.0
    path.write_text(json.dumps(document))
    assert read_map(path, SlamConfig()).mapper.directions.total == 0.0


def test_a_file_that_is_not_a_map_is_refused(half: tuple[LineSlam, Path], tmp_path: Path) -> None:
    _, path = half
    cut = tmp_path / "cut.json"
    cut.write_text(path.read_text()[:1000])
    for wrong in (cut, tmp_path / "none.json", tmp_path):
        with pytest.raises(InputError, match=str(wrong)):
            read_map(wrong, SlamConfig())
    with pytest.raises(InputError, match=r"mode=hopslam"):
        read_map(path, SlamConfig(mode="paper"))
    with pytest.raises(InputError, match=r"--set slam.map.cell=0.2"):
        read_map(path, SlamConfig.model_validate({"map": {"cell": 0.3}}))
