"""The agent's views against the world around it, and the picture from above."""

from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from slam.env import rerun_window
from slam.env.config import EnvConfig
from slam.env.occupancy_grid import Extent
from slam.env.p3dx_env import P3DXEnv
from slam.env.step_state import StepState
from slam.env.top_view import TopView
from slam.errors import ScenarioError
from slam.pose import Pose2D
from slam.run.pilots import RouteProgress
from slam.run.viewer.viewers import Viewers
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

STRAIGHT = np.array([0.5, 0.0], np.float32)


@pytest.fixture
def env() -> Iterator[P3DXEnv]:
    with P3DXEnv("paper_simulation", observe=("slam_pose", "map", "goal"), render_mode="rgb_array") as env:
        env.reset(seed=0)
        yield env


def test_the_map_crop_is_centred_on_the_robot_and_heads_up(env: P3DXEnv) -> None:
    for _ in range(3):
        observation, *_ = env.step(STRAIGHT)
    crop = observation["map"][0]
    assert crop[28:32, 31:33].tolist() == [[127] * 2] * 4  # ahead of the robot, which stands in the middle
    assert set(np.unique(crop)) == {0, 127, 255}
    walls = np.argwhere(crop == 255)
    scan, mount = env.episode.state.observation.scan, env.scenario.lidar.mount.pose
    points = mount.transform(scan.points())
    cells = np.column_stack([32 - points[:, 0] / 0.1, 32 - points[:, 1] / 0.1])
    cells = cells[(cells > 1).all(axis=1) & (cells < 63).all(axis=1)]
    off = np.abs(cells[:, None] - 0.5 - walls[None]).max(axis=2).min(axis=1)
    assert off.max() < 1.5  # cells: the grid of the map is not turned with the robot


@pytest.mark.parametrize("form", ["polar", "xy"])
def test_the_goal_is_relative_to_the_robot(env: P3DXEnv, form: str) -> None:
    scenario, config = env.scenario, EnvConfig(observe=("goal",), goal_as=form)
    view = config.make_views(scenario, Extent.of(scenario))["goal"]
    seen, pose = env.episode.state.observation, Pose2D(1.0, 2.0, np.pi / 2)
    state = StepState(seen, pose, pose, Pose2D(-2.0, 6.0), False, 5.0, None)
    expected = [5.0, np.arctan2(3.0, 4.0)] if form == "polar" else [4.0, 3.0]
    np.testing.assert_allclose(view.of(state), expected, rtol=1e-6)
    assert view.of(state) in view.space
    arrived = StepState(seen, pose, pose, None, True, 0.0, None)
    assert view.of(arrived).tolist() == [0.0, 0.0]


def test_the_distance_left_is_along_the_waypoints() -> None:
    route = RouteProgress(Pose2D(), [(3.0, 0.0), (3.0, 4.0)], arrival=0.5)
    assert (route.length, route.remaining, route.goal) == (7.0, 7.0, Pose2D(3.0, 0.0))
    route.advance(Pose2D(-1.0, 0.0))
    assert route.remaining == 8.0
    route.advance(Pose2D(2.6, 0.0))
    assert (route.goal, route.remaining) == (Pose2D(3.0, 4.0), pytest.approx(np.hypot(0.4, 4.0)))
    route.advance(Pose2D(3.0, 4.0))
    assert (route.goal, route.remaining, route.arrived) == (None, 0.0, True)
    assert not RouteProgress(Pose2D(), [], 0.5).arrived


def test_the_picture_shows_the_world_and_changes_with_the_robot(env: P3DXEnv) -> None:
    first = env.render()
    assert first is not None
    assert first.dtype == np.uint8
    assert all(side % 16 == 0 for side in first.shape[:2])
    assert first.shape[2] == 3
    for _ in range(5):
        env.step(STRAIGHT)
    second = env.render()
    assert 0 < np.count_nonzero((first != second).any(axis=2)) < 0.5 * first[:, :, 0].size


def test_world_coordinates_map_to_pixels() -> None:
    world = {
        "boxes": [{"center": (3.0, 1.0), "size": (0.5, 0.5, 1.0)}, {"center": (-3.0, -1.0), "size": (1.0, 1.0, 1.0)}]
    }
    scenario = Scenario.model_validate({"name": "two boxes", "world": world})
    with P3DXEnv(scenario, reward="none", render_mode="rgb_array") as env:
        env.reset(seed=0)
        frame = env.render()
    dark = np.argwhere((frame == (70, 74, 82)).all(axis=2))
    right, left = dark[dark[:, 1] > frame.shape[1] / 2], dark[dark[:, 1] < frame.shape[1] / 2]
    assert right[:, 0].mean() < frame.shape[0] / 2 < left[:, 0].mean()  # y points up
    assert len(left) == pytest.approx(4 * len(right), rel=0.15)  # one square metre, and a quarter of one


def test_without_a_render_mode_there_is_no_picture() -> None:
    with P3DXEnv("paper_simulation") as env:
        env.reset(seed=0)
        assert env.render() is None


def test_in_human_mode_every_episode_is_a_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = (str(tmp_path / f"{k}.rrd") for k in count())
    monkeypatch.setattr(rerun_window, "has_display", lambda: True)
    monkeypatch.setattr(rerun_window, "Viewers", lambda target, console: Viewers(next(files)))
    with gymnasium.make("hopslam/PaperSimulation-v0", render_mode="human") as env:
        for seed in (1, 2):
            env.reset(seed=seed)
            env.step(STRAIGHT)
            assert env.render() is None
    assert all((tmp_path / f"{k}.rrd").stat().st_size > 10_000 for k in range(2))


def test_without_a_screen_human_mode_warns_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("has_display", "is_listening"):
        monkeypatch.setattr(rerun_window, name, lambda *_: False)
    with P3DXEnv("paper_simulation", render_mode="human") as env:
        for seed in (1, 2):
            env.reset(seed=seed)
            env.step(STRAIGHT)
    assert capsys.readouterr().err.count('choose "rgb_array"') == 1


def test_a_new_world_fits_into_the_old_picture(env: P3DXEnv) -> None:
    view = TopView(env.scenario, Extent.of(env.scenario))
    size = view.size
    corridor = load_scenario("corridor")
    view.show(corridor, Extent.of(corridor))
    assert view.frame(env.episode.state, np.empty((0, 2, 2))).shape == (size[1], size[0], 3)


def test_a_random_world_changes_with_the_seed() -> None:
    random = ["generate.kind=office", "world.walls=[]", "world.boxes=[]", "world.tables=[]", "route.waypoints=[[1, 0]]"]
    with gymnasium.make("hopslam/P3DX-v0", scenario="corridor", settings=random, render_mode="rgb_array") as env:
        pictures: dict[int, Any] = {}
        for seed in (1, 2, 1):
            observation, _ = env.reset(seed=seed)
            picture = (env.render().tobytes(), observation["scan"].tobytes())
            assert pictures.setdefault(seed, picture) == picture
    assert pictures[1] != pictures[2]


def test_a_random_lidar_is_refused() -> None:
    def reset_often(env: P3DXEnv) -> None:
        for seed in range(20):
            env.reset(seed=seed)

    env = P3DXEnv("paper_simulation", ["lidar.model={choice: [urg04lx, table1]}"])
    with env, pytest.raises(ScenarioError, match=r"lidar\.model cannot change"):
        reset_often(env)
