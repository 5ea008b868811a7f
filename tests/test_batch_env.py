"""The batch: each of its robots equals the single kinematic robot, whatever its neighbours are."""

from itertools import zip_longest
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

import sim  # noqa: F401  registers the ids
from sim.lidar_noise import NOISES
from slam.env.occupancy_grid import Extent, OccupancyGrid
from slam.env.rewards import REWARDS
from slam.errors import InputError, ScenarioError
from slam.lidars import LIDARS
from slam.pose import Pose2D
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from tests.rooms import room_scenario

ID = "hopslam/ClutteredRoom-v0"
PLAN = "physics.engine=plan"
QUIET = ("lidar.noise=none", "robot.odometry.travel_noise=0")
PEOPLE = "people=[{waypoints: [[1.0, 1.0], [3.0, 1.0]], keep: 0.0}]"
VIEWS = ("scan", "odometry", "goal", "map")


def batch(count: int, **arguments: Any) -> VectorEnv:
    return gymnasium.make_vec(ID, num_envs=count, vectorization_mode="vector_entry_point", **arguments)


def actions(count: int, steps: int) -> np.ndarray:
    return np.random.default_rng(3).uniform([-0.2, -1.0], [1.0, 1.0], (steps, count, 2)).astype(np.float32)


@pytest.mark.parametrize("arguments", [{}, {"action": "wheels", "reward": "coverage", "goal_as": "xy"}])
def test_a_robot_in_the_batch_equals_the_single_robot(arguments: dict[str, object]) -> None:
    """The wheels have errors, and people walk. Lidar noise is off, as the batch draws it from another random stream."""
    wheels = ["robot.odometry.left_radius=0.099", "robot.odometry.track=0.34", "robot.traction.slip=0.03"]
    given = {"settings": [PLAN, *QUIET, PEOPLE, *wheels], "collision_penalty": 0.5, "end_on": ()} | arguments
    given["observe"] = ("scan", "odometry", "goal")
    envs, single = batch(3, **given), gymnasium.make(ID, **given)
    seen, info = envs.reset(seed=1)
    alone, alone_info = single.reset(seed=1)
    hits, steps = 0, actions(3, 90)
    steps[30:, 1] = [1.0, 1.0 if "action" in arguments else 0.0]
    for step in [None, *steps]:
        if step is not None:
            seen, rewards, terminated, truncated, info = envs.step(step)
            alone, reward, *ends, alone_info = single.step(step[1])
            assert rewards[1] == pytest.approx(reward, abs=1e-9)
            assert [terminated[1], truncated[1]] == ends
            hits += alone_info["collided"]
        np.testing.assert_allclose(seen["scan"][1], alone["scan"], atol=1.1e-3)
        assert (abs(seen["scan"][1] - alone["scan"]) > 1e-5).mean() < 0.01  # those are rounded to another mm
        for key in ("odometry", "goal"):
            np.testing.assert_allclose(seen[key][1], alone[key], atol=2e-6)
        for key in ("T_map_base", "collided", "stalled", "applied", "stamp", "seconds", "route_left", "ending"):
            value = info[key][1]
            assert value == alone_info[key] if key == "ending" else value == pytest.approx(alone_info[key], abs=1e-9)
    assert hits > 0
    envs.close()
    single.close()


def test_the_bits_do_not_depend_on_threads_or_neighbours() -> None:
    runs = []
    for count, threads in ((5, 1), (5, 3), (4, 2)):
        envs = batch(count, threads=threads, observe=VIEWS, settings=["lidar.noise=realistic", PEOPLE], max_seconds=0.8)
        observations, _ = envs.reset(seed=7)
        steps = [observations] + [envs.step(step[:count])[0] for step in actions(5, 20)]
        runs.append([np.concatenate([step[key][:4].ravel() for key in VIEWS]).tobytes() for step in steps])
        envs.close()
    assert runs[0] == runs[1] == runs[2]


@pytest.mark.parametrize(("reward", "noise"), list(zip_longest(REWARDS, NOISES, fillvalue="none")))
def test_a_batch_has_every_noise_and_reward(reward: str, noise: str) -> None:
    envs = batch(1, reward=reward, settings=["lidar.model=table1", f"lidar.noise={noise}"])
    envs.reset(seed=0)
    assert reward in envs.step(np.zeros((1, 2), np.float32))[-1]["reward"]
    envs.close()


@pytest.mark.parametrize("noise", ["paper", "datasheet", "realistic"])
def test_noise_is_that_of_the_single_lidar(noise: str) -> None:
    """At rest, mean and spread of each beam are the same over many robots of a batch and over many scans of one
    robot."""
    settings = [f"lidar.noise={noise}", "lidar.model=table1", PLAN, "lidar.dropout=0.05"]
    envs, single = batch(400, settings=settings), gymnasium.make(ID, settings=settings)
    many = envs.reset(seed=1)[0]["scan"]
    one = [single.reset(seed=seed)[0]["scan"] for seed in range(400)]
    envs.close()
    single.close()
    kept = [np.where((scans > 0.1) & (scans < 3.9), scans, np.nan) for scans in (many, np.array(one))]
    seen = np.isfinite(kept[0]).mean(axis=0)
    assert abs(seen - np.isfinite(kept[1]).mean(axis=0)).max() < 0.12
    beams = seen > 0.8
    assert beams.sum() > 30
    mean, spread = ([f(scans[:, beams], axis=0) for scans in kept] for f in (np.nanmean, np.nanstd))
    assert (abs(mean[0] - mean[1]) / (0.002 + spread[1] * np.sqrt(2.0 / 400))).max() < 5.0
    assert abs(np.log(spread[0] / spread[1])).max() < 0.4
    assert abs(np.log(spread[0] / spread[1]).mean()) < 0.02


def test_the_map_is_that_of_an_occupancy_grid_at_the_true_pose() -> None:
    envs = batch(2, observe=("scan", "map"), settings=QUIET, map_cells=32, cell=0.07)
    scenario, lidar = envs.scenario, envs.scenario.lidar.description.lidar
    grid = OccupancyGrid(Extent.of(scenario), 0.07)
    seen, info = envs.reset(seed=0)
    offsets = (16 - 0.5 - np.arange(32)) * 0.07
    x, y = np.meshgrid(offsets, offsets, indexing="ij")
    for step in actions(2, 15):
        pose = Pose2D(*info["T_map_base"][1])
        ranges = np.where(seen["scan"][1] >= lidar.range_max, np.inf, seen["scan"][1]).astype(np.float64)
        ranges[ranges == 0.0] = -np.inf
        bounds = lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max
        grid.add_scan(LaserScan(0.0, *bounds, ranges), pose @ scenario.lidar.mount.pose)
        expected = grid.at(pose.transform(np.column_stack([x.ravel(), y.ravel()]))).reshape(32, 32)
        assert (seen["map"][1, 0] == np.array([0, 127, 255])[expected]).mean() > 0.99  # but for rays along a border
        seen, *_, info = envs.step(step)
    envs.close()


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_autoreset_modes_equal_those_of_gymnasium(mode: AutoresetMode) -> None:
    """Shapes, ends and resets are those of a ``SyncVectorEnv`` of the same robots, and no returned array is reused."""
    given = {"settings": [PLAN, *QUIET], "max_seconds": 0.5}
    ours = batch(2, autoreset_mode=mode, **given)
    other = gymnasium.make_vec(
        ID, num_envs=2, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, **given
    )
    kept = []
    ours.reset(seed=[1, 2])
    other.reset(seed=[1, 2])
    for k, step in enumerate(actions(2, 8)):
        if mode == AutoresetMode.DISABLED and k == 4:
            for envs in (ours, other):
                envs.reset(options={"reset_mask": np.array([True, True])})
        seen = [envs.step(step) for envs in (ours, other)]
        for one, another in zip(*seen, strict=True):
            if isinstance(one, np.ndarray):
                np.testing.assert_allclose(one, another, atol=1e-6)
        np.testing.assert_allclose(seen[0][0]["odometry"], seen[1][0]["odometry"], atol=2e-6)
        infos = seen[0][4], seen[1][4]
        assert list(infos[0]["ending"]) == list(infos[1]["ending"])
        assert ("final_obs" in infos[0]) == ("final_obs" in infos[1])
        if "final_obs" in infos[0]:
            finals = [info["final_obs"][1]["odometry"] for info in infos]
            np.testing.assert_allclose(*finals, atol=2e-6)
            assert list(infos[0]["final_info"]["ending"]) == list(infos[1]["final_info"]["ending"]) == ["time", "time"]
        kept.append((seen[0][0]["scan"], seen[0][0]["scan"].copy()))
    ours.close()
    other.close()
    for array, copy in kept:
        np.testing.assert_array_equal(array, copy)


def test_the_seed_draws_the_worlds_of_the_episodes() -> None:
    name, arguments = "hopslam/RandomOffice-v0", {"worlds": 3, "settings": [*QUIET, "lidar.dropout=0"]}
    scans = []
    for seed in (1, 1, 2):
        envs = gymnasium.make_vec(name, num_envs=12, vectorization_mode="vector_entry_point", **arguments)
        seen, _ = envs.reset(seed=seed)
        assert envs.observation_space.contains(seen)
        scans.append(seen["scan"])
        envs.close()
    assert (scans[0] == scans[1]).all()
    assert not (scans[0] == scans[2]).all()
    assert len(np.unique(scans[0], axis=0)) == 3


def test_robots_without_a_seed_differ() -> None:
    envs = batch(3)
    scans = envs.reset(seed=[None, 5, None])[0]["scan"]
    envs.close()
    assert len(np.unique(scans, axis=0)) == 3


@pytest.mark.parametrize("model", [name for name, model in LIDARS.items() if not model.beams_vary])
def test_a_constant_lidar_equals_the_single_lidar(model: str) -> None:
    settings = [*QUIET, f"lidar.model={model}", PLAN]
    envs, single = batch(2, settings=settings), gymnasium.make(ID, settings=settings)
    seen, alone = envs.reset(seed=0)[0]["scan"][0], single.reset(seed=0)[0]["scan"]
    assert envs.observation_space["scan"].contains(np.array([seen, seen]))
    np.testing.assert_allclose(seen, alone, atol=1.01 * LIDARS[model].resolution)
    envs.close()
    single.close()


def test_varying_beams_are_read_within_half_a_step() -> None:
    """Each observed range is that of the real beam nearest to its bearing, at most half a step away: it lies between
    the least and the largest true range there. All 40 scans differ."""
    room, lidar = room_scenario((-2.0, 3.5), (-2.0, 2.0), model="ld19"), LIDARS["ld19"].lidar
    given = {"vectorization_mode": "vector_entry_point", "reward": "none"}
    envs = gymnasium.make_vec("hopslam/P3DX-v0", num_envs=40, scenario=room, **given)
    turns = [envs.reset(seed=0)[0]["scan"], envs.step(np.zeros((40, 2)))[0]["scan"]]
    envs.close()
    bearings = lidar.angles[:, None] + 0.51 * lidar.angle_increment * np.linspace(-1.0, 1.0, 21)
    with np.errstate(divide="ignore"):
        ahead = np.where(np.cos(bearings) > 0.0, 3.5, -2.0) / np.cos(bearings)
        ranges = np.minimum(ahead, abs(2.0 / np.sin(bearings)))
    for scans in turns:
        assert (scans > ranges.min(axis=1) - 1e-3).all()
        assert (scans < ranges.max(axis=1) + 2e-3).all()
        assert len(np.unique(scans, axis=0)) == 40
    assert not (turns[0] == turns[1]).all(axis=1).any()


def test_a_lidar_sees_people_up_to_the_height_of_their_legs() -> None:
    """Both the lidar of the single robot and that of the batch do."""
    for height, seen in ((0.84, True), (0.86, False)):
        scans = []
        for people in ((), ("people=[{waypoints: [[1.5, 0.0]]}]",)):
            settings = [*QUIET, *people, f"lidar.height={height}", PLAN, "robot.start={x: 0.0, y: 0.0, theta: 0.0}"]
            envs, single = batch(1, settings=settings), gymnasium.make(ID, settings=settings)
            scans.append([envs.reset(seed=0)[0]["scan"][0], single.reset(seed=0)[0]["scan"]])
            envs.close()
            single.close()
        assert [bool((with_people < without).any()) for without, with_people in zip(*scans, strict=True)] == [seen] * 2


def test_a_plain_make_vec_keeps_the_engine() -> None:
    envs = gymnasium.make_vec(ID, num_envs=2)
    assert isinstance(envs, SyncVectorEnv)
    assert envs.envs[0].unwrapped.scenario.physics.engine == load_scenario("corridor").physics.engine
    envs.close()


def test_impossible_arguments_are_refused_in_one_line() -> None:
    with pytest.raises(ScenarioError, match="environment argument rewrd"):
        batch(2, rewrd="none")
    with pytest.raises(InputError, match="autoreset_mode='SameStp'; did you mean SameStep"):
        batch(2, autoreset_mode="SameStp")
    with pytest.raises(InputError, match="worlds=0: give 1 or more"):
        batch(2, worlds=0)
    with pytest.raises(InputError, match="a batch draws nothing"):
        batch(2, render_mode="human")
    envs = batch(2)
    envs.reset(seed=0)
    with pytest.raises(InputError, match=r"shape \(2, 2\)"):
        envs.step(np.zeros(2))
    with pytest.raises(InputError, match="that of robot 1 is"):
        envs.step(np.array([[0.0, 0.0], [np.nan, 0.0]]))
    envs.close()
