"""Localization of the robot in a saved map."""

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from slam.cli.main import app
from slam.config import SlamConfig
from slam.errors import InputError
from slam.line_localizer import LineLocalizer, LocalizeThenMap
from slam.line_slam import LineSlam
from slam.mapping.surfel_map import SurfelMap
from slam.matching.global_search import _bounds, _pooled
from slam.matching.surfel_mapper import SurfelMapper
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.run.pilots import Wanderer
from slam.saved_slam import SavedSlam, relocate, save
from slam.scan import LaserScan

MOUNT = Pose2D(0.1, 0.0, 0.0)
Look = Callable[[Pose2D, int], LaserScan]


@pytest.fixture(scope="module")
def look(scan_of: Callable[..., LaserScan], room: FloatArray) -> Look:
    """A function that takes a scan in the room, for a pose of the base and the number of the scan."""
    return lambda pose, k: scan_of(room, pose @ MOUNT, k)


@pytest.fixture(scope="module")
def saved(look: Look) -> SavedSlam:
    """A map of the room, seen from a loop through it."""
    slam = LineSlam(SlamConfig(), MOUNT)
    for k, pose in enumerate(loop(Pose2D(), 63)):
        slam.update(look(pose, k), Odometry(0.1 * k, pose))
    made = save(slam)
    assert made is not None
    return made


def loop(start: Pose2D, steps: int) -> list[Pose2D]:
    """Circles of 0.5 m."""
    return [start @ Pose2D(0.5 * np.sin(0.1 * k), 0.5 - 0.5 * np.cos(0.1 * k), 0.1 * k) for k in range(steps)]


def drive(look: Look, localizer: LineLocalizer | LocalizeThenMap, path: list[Pose2D], begun: Pose2D) -> Pose2D:
    """Drive along a path with odometry that continues from ``begun``; return the odometry at the end."""
    for k, pose in enumerate(path):
        odometry = begun @ path[0].between(pose)
        localizer.update(look(pose, k), Odometry(0.1 * k, odometry))
    return odometry


@settings(max_examples=4)
@given(st.floats(-1.5, 2.5), st.floats(-0.7, 1.0), st.floats(-3.1, 3.1))
def test_the_robot_is_localized_anywhere_in_the_map(
    saved: SavedSlam, look: Look, x: float, y: float, theta: float
) -> None:
    path = loop(Pose2D(x, y, theta), 15)
    before = saved.mapper.map.surfels.copy()
    localizer = LineLocalizer(SlamConfig(), MOUNT, saved.mapper.map)
    drive(look, localizer, path, Pose2D())
    assert localizer.sure
    assert localizer.T_map_base.distance(path[-1]) < 0.03
    assert abs(localizer.T_map_base.between(path[-1]).theta) < np.radians(1.0)
    assert np.array_equal(saved.mapper.map.surfels, before)


def test_the_robot_is_localized_by_scans_alone(saved: SavedSlam, look: Look) -> None:
    path, localizer = (
        loop(Pose2D(1.0, 0.5, 2.0), 30),
        LineLocalizer(SlamConfig(odometry=False), MOUNT, saved.mapper.map),
    )
    for k, pose in enumerate(path):
        localizer.update(look(pose, k), Odometry(0.1 * k, Pose2D()))
    assert localizer.sure
    assert localizer.T_map_base.distance(path[-1]) < 0.03


@pytest.mark.parametrize("offset", [Pose2D(0.2), Pose2D(-0.2), Pose2D(0.0, 0.2), Pose2D(0.0, -0.2)])
def test_a_map_pulls_back_a_robot_that_is_20_cm_off(saved: SavedSlam, look: Look, offset: Pose2D) -> None:
    path = loop(Pose2D(1.0, 0.3, 0.5), 20)
    wrong = Pose2D(path[0].x + offset.x, path[0].y + offset.y, path[0].theta)
    for tracking in (
        LineLocalizer(SlamConfig(), MOUNT, saved.mapper.map, wrong),
        relocate(SlamConfig(), MOUNT, deepcopy(saved), wrong),
    ):
        for k, pose in enumerate(path):
            tracking.update(look(pose, k), Odometry(0.1 * k, pose))
        assert tracking.T_map_base.distance(path[-1]) < 0.03


def test_a_kidnapped_robot_is_localized_again(saved: SavedSlam, look: Look) -> None:
    localizer = LineLocalizer(SlamConfig(), MOUNT, saved.mapper.map, Pose2D())
    wheels = drive(look, localizer, loop(Pose2D(), 10), Pose2D())
    assert localizer.sure
    path, lost = loop(Pose2D(2.5, 0.8, 2.0), 40), False
    for k, pose in enumerate(path):
        odometry = Odometry(0.1 * k, wheels @ path[0].between(pose))
        lost |= localizer.update(look(pose, k), odometry).lost
    assert lost
    assert localizer.sure
    assert localizer.T_map_base.distance(path[-1]) < 0.03


def test_in_another_building_the_robot_is_not_localized(saved: SavedSlam, scan_of: Callable[..., LaserScan]) -> None:
    hall = np.array([[-1, -1.3], [1.2, -1.0], [1.6, 1.4], [0.3, 2.0], [-1.4, 1.1], [-1, -1.3]], float)
    localizer = LineLocalizer(SlamConfig(), MOUNT, saved.mapper.map)
    for k, pose in enumerate(loop(Pose2D(0.0, -0.3, 0.0), 30)):
        assert localizer.update(scan_of(hall, pose @ MOUNT, k), Odometry(0.1 * k, pose)).lost


def test_an_empty_map_and_an_empty_scan_do_no_harm(look: Look) -> None:
    config = SlamConfig()
    localizer = LineLocalizer(config, MOUNT, SurfelMap(config.map))
    blind = LaserScan(0.0, -2.0, 0.01, 0.05, 8.0, np.full(401, np.inf))
    assert localizer.update(blind, Odometry(0.0, Pose2D())).lost
    assert localizer.update(look(Pose2D(), 0), Odometry(0.1, Pose2D(0.1))).lost


def test_mapping_continues_once_the_place_is_found(saved: SavedSlam, look: Look) -> None:
    continuation = LocalizeThenMap(SlamConfig(), MOUNT, saved)
    path = loop(Pose2D(1.0, 0.5, 1.0), 40)
    drive(look, continuation, path, Pose2D())
    assert continuation.slam is not None
    assert isinstance(continuation.slam.mapper, SurfelMapper)
    assert continuation.T_map_base.distance(path[-1]) < 0.03


def test_bounds_are_never_below_any_score_of_their_block() -> None:
    random = np.random.default_rng(0)
    pictures = random.integers(0, 64, (9, 60, 60), np.uint8)
    facets = np.zeros((5, 7))
    facets[:, :2] = random.uniform(-1, 1, (5, 2))
    bounds = _bounds(facets, 20, (6, 4, 4), _pooled(pictures))
    for a in range(6):
        places = Pose2D(theta=a * np.pi / 3).transform(facets[:, :2]) / 0.1
        shifts = np.floor(places + 0.5).astype(int)
        for i in range(16):
            for j in range(16):
                score = sum(int(pictures[8, 20 + i + dy, 20 + j + dx]) for dx, dy in shifts)
                assert score <= bounds[a, i // 4, j // 4]


def test_a_wanderer_turns_before_a_wall() -> None:
    angles = np.linspace(-2.0, 2.0, 401)

    def seen(ahead: float) -> LaserScan:
        with np.errstate(divide="ignore"):
            ranges = np.minimum(2.0 / np.abs(np.sin(angles)), np.where(np.cos(angles) > 0, ahead / np.cos(angles), 9.0))
        return LaserScan(0.0, -2.0, 0.01, 0.05, 8.0, ranges)

    wanderer = Wanderer()
    free = wanderer.command(Pose2D(), seen(3.0))
    assert free.linear > 0.3
    assert abs(free.angular) < 0.05
    blocked = wanderer.command(Pose2D(), seen(0.4))
    assert blocked.linear == 0.0
    assert abs(blocked.angular) > 0.5
    assert wanderer.command(Pose2D(), seen(0.7)) == blocked
    assert wanderer.command(Pose2D(), seen(1.0)).linear > 0.0


def test_the_commands_localize_in_a_saved_map(small_log: Path, tmp_path: Path) -> None:
    run = CliRunner()
    made = run.invoke(app, ["replay", str(small_log), "--out", str(tmp_path / "a")])
    assert made.exit_code == 0, made.output
    saved_map = tmp_path / "a" / "map.json"
    again = ["--map", str(saved_map), "--out"]
    for number, arguments in enumerate((["localize"], ["replay"], ["replay", "--start", "saved"])):
        folder = tmp_path / f"b{number}"
        result = run.invoke(app, [arguments[0], str(small_log), *arguments[1:], *again, str(folder)])
        assert result.exit_code == 0, result.output
        assert (folder / "map.png").is_file()
    assert not (tmp_path / "b0" / "map.json").exists()
    assert "sure_after_s" in (tmp_path / "b0" / "metrics.json").read_text()
    assert (tmp_path / "b2" / "map.json").is_file()


@pytest.mark.usefixtures("no_pictures")
def test_localize_has_the_options_of_replay(small_log: Path, tmp_path: Path) -> None:
    """It takes a run folder with its settings, or a bag with topics; scenario and log refuse the other's options."""
    run, folder = CliRunner(), tmp_path / "run"
    where = ["--map", str(folder / "map.json"), "--out"]
    made = run.invoke(app, ["replay", str(small_log), "--set", "slam.deskew=false", "--out", str(folder)])
    assert made.exit_code == 0, made.output
    for number, words in enumerate(([folder], [folder / "log.mcap", "--scan-topic", "/scan", "--odom-topic", "/odom"])):
        result = run.invoke(app, ["localize", *map(str, words), *where, str(tmp_path / f"found{number}")])
        assert result.exit_code == 0, result.output
        assert "deskew: " + ("true" if number else "false") in (tmp_path / f"found{number}" / "config.yaml").read_text()
    for words, said in (
        ([str(folder), "--seed", "3"], "--seed 3"),
        (["corridor", "--scan-topic", "/scan"], "corridor is a scenario, and no log"),
        ([str(folder / "log.mcap"), "--scan-topic", "/other"], "/other"),
    ):
        refused = run.invoke(app, ["localize", *words, *where, str(tmp_path / "none")])
        assert isinstance(refused.exception, InputError)
        assert said in str(refused.exception)
