"""The learning environment: the rules of Gymnasium, and agreement with the robot."""

import copy
import hashlib
import pickle
import subprocess
import sys
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sim  # noqa: F401  registers the ids
from slam.env.config import EnvConfig
from slam.env.ids import ENV_IDS
from slam.env.p3dx_env import P3DXEnv
from slam.errors import InputError, RobotError, ScenarioError
from slam.pose import Pose2D
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario
from slam.scenario.shipped import shipped_scenarios

ALL_VIEWS = ("scan", "odometry", "slam_pose", "map", "goal")
STRAIGHT = np.array([0.5, 0.0], np.float32)


def make(**arguments: Any) -> gymnasium.Env:
    return gymnasium.make("hopslam/P3DX-v0", **{"scenario": "paper_simulation"} | arguments)


def rollout(env: gymnasium.Env, seed: int, steps: int = 15) -> list[np.ndarray]:
    """Everything that an episode of random actions shows, in order."""
    observation, info = env.reset(seed=seed)
    env.action_space.seed(seed)
    seen = [*observation.values(), info["T_map_base"]]
    for _ in range(steps):
        observation, reward, *_, info = env.step(env.action_space.sample())
        seen += [*observation.values(), info["T_map_base"], np.array(reward)]
    return seen


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_every_id_keeps_the_rules_of_gymnasium(env_id: str) -> None:
    with gymnasium.make(env_id) as env:
        check_env(env.unwrapped)


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_every_id_keeps_the_rules_of_stable_baselines(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own imports
        checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="pip install 'hopslam[rl]'")
    for arguments in ({}, {"observe": ALL_VIEWS, "action": "wheels", "reward": "coverage", "end_on": ["lost"]}):
        with gymnasium.make(env_id, **arguments) as env:
            checker.check_env(env.unwrapped)


def test_every_shipped_world_has_an_id_and_no_id_is_left_over() -> None:
    drivable = set(shipped_scenarios()) - {"replay", "paper_replay"}
    assert sorted(name for name in ENV_IDS.values() if name) == sorted(drivable)
    for env_id, name in ENV_IDS.items():
        assert gymnasium.spec(env_id).kwargs == ({"scenario": name} if name else {})


def test_gymnasium_finds_the_ids_without_an_import() -> None:
    code = (
        "import gymnasium, sys; env = gymnasium.make('sim:hopslam/Corridor-v0'); "
        "observation, info = env.reset(seed=1); print(observation['scan'].shape)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.startswith("(682,)")


def test_importing_sim_costs_no_pybullet() -> None:
    code = "import sim, sys; assert 'pybullet' not in sys.modules and 'sim.robot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("reward", ["progress", "coverage", "none"])
def test_two_environments_with_one_seed_agree_bit_by_bit(reward: str) -> None:
    with make(observe=ALL_VIEWS, reward=reward) as mine, make(observe=ALL_VIEWS, reward=reward) as other:
        first = rollout(mine, 5)
        rollout(other, 6)
        for again in (rollout(other, 5), rollout(mine, 5)):
            np.testing.assert_equal(again, first)
        assert any((a != b).any() for a, b in zip(first, rollout(mine, 6), strict=True))


def test_a_fresh_process_agrees_bit_by_bit() -> None:
    code = (
        "import sys, hashlib, runpy; sys.argv = ['']; here = runpy.run_path('tests/test_env.py'); "
        "seen = here['rollout'](here['make'](reward='coverage'), 5); "
        "print(hashlib.sha256(b''.join(a.tobytes() for a in seen)).hexdigest())"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    with make(reward="coverage") as env:
        seen = rollout(env, 5)
    assert out.strip() == hashlib.sha256(b"".join(a.tobytes() for a in seen)).hexdigest()


def test_resets_without_a_seed_differ() -> None:
    with make() as env:
        env.reset(seed=1)
        scans = [env.reset()[0]["scan"] for _ in range(2)]
    assert (scans[0] != scans[1]).any()


def test_every_step_returns_new_arrays() -> None:
    with make(observe=ALL_VIEWS) as env:
        first, info = env.reset(seed=0)
        kept = {key: value.copy() for key, value in first.items()}, info["T_map_base"].copy()
        second, *_, later = env.step(STRAIGHT)
        np.testing.assert_equal((first, info["T_map_base"]), kept)
        assert not any(np.shares_memory(first[key], second[key]) for key in first)
        assert not np.shares_memory(info["T_map_base"], later["T_map_base"])


def test_the_observation_is_what_the_robot_saw() -> None:
    with make(observe=ALL_VIEWS) as env:
        env.reset(seed=0)
        observation, *_, info = env.step(np.array([9.0, 0.0]))
        seen, estimate = info["observation"], env.unwrapped.episode.state.estimated_pose
    echoes = seen.scan.echoes
    np.testing.assert_allclose(observation["scan"][echoes], seen.scan.ranges[echoes], rtol=1e-6)
    assert (observation["scan"][np.isposinf(seen.scan.ranges)] == np.float32(seen.scan.range_max)).all()
    assert observation["odometry"][0] == pytest.approx(seen.odometry.T_odom_base.x)
    np.testing.assert_allclose(observation["slam_pose"], [estimate.x, estimate.y, estimate.theta], rtol=1e-6)
    np.testing.assert_array_equal(info["applied"], [1.2, 0.0])


def test_slam_runs_only_if_something_needs_it() -> None:
    for arguments, runs in (({}, False), ({"observe": ["map"]}, True), ({"end_on": ["lost"]}, True)):
        with make(**arguments) as env:
            _, info = env.reset(seed=0)
            assert (env.unwrapped.episode.slam is not None) == runs == ("slam_pose" in info)


def test_equal_wheel_speeds_and_twists_do_the_same() -> None:
    with make() as twists, make(action="wheels") as wheels:
        twists.reset(seed=3)
        wheels.reset(seed=3)
        for _ in range(5):
            *_, one = twists.step(np.array([0.25, 0.5 / 0.33]))
            *_, other = wheels.step(np.array([0.0, 0.5]))
    np.testing.assert_allclose(one["T_map_base"], other["T_map_base"], atol=1e-9)


@pytest.mark.parametrize("action", [[0.1], [0.1, 0.2, 0.3], 0.5, [np.nan, 0.0], [np.inf, 0.0], ["a", "b"], None])
def test_an_invalid_action_is_refused(action: object) -> None:
    with P3DXEnv("paper_simulation") as env:
        env.reset(seed=0)
        with pytest.raises(InputError, match=r"an action is \(v, omega\)"):
            env.step(action)


@pytest.mark.parametrize(
    ("options", "place", "left"),
    [
        ({"start": [1.0, 1.8]}, (1.0, 1.8, 0.0), None),
        ({"start": np.array([1.0, 1.8, 0.5])}, (1.0, 1.8, 0.5), None),
        ({"goal": (1.0, 3.0)}, (1.0, 1.0, np.pi / 2), 2.0),
        ({"start": Pose2D(1.0, 1.8), "goal": [1.0, 2.8]}, (1.0, 1.8, 0.0), 1.0),
        ({"settings": "robot.start.y=1.7"}, (1.0, 1.7, np.pi / 2), 5.3),
        ({"settings": ["robot.start.y=1.7", "route.waypoints=[[1, 2.7]]"]}, (1.0, 1.7, np.pi / 2), 1.0),
        ({}, (1.0, 1.0, np.pi / 2), 6.0),
        (None, (1.0, 1.0, np.pi / 2), 6.0),
    ],
)
def test_options_change_one_episode(options: dict[str, object] | None, place: tuple[float, ...], left: float) -> None:
    with make() as env:
        _, usual = env.reset(seed=0)
        _, info = env.reset(seed=0, options=options)
        assert info["pose"] == pytest.approx(place, abs=1e-3)
        assert left is None or info["route_left"] == pytest.approx(left, abs=1e-3)
        _, again = env.reset(seed=0)
        np.testing.assert_array_equal(again["pose"], usual["pose"])
        assert again["route_left"] == usual["route_left"]


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"strat": [0, 0]}, "no option 'strat'; did you mean start?"),
        ({"seed": 3}, "no option 'seed'; known here: start, goal, settings"),
        ({"start": [0.0, 0.0]}, r"options: start: \(0, 0\) is inside a solid"),
        ({"goal": [0.0, 0.0]}, r"options: goal: \(0, 0\) is inside a solid"),
        ({"start": "door"}, r"give \[x, y\] or \[x, y, theta\]"),
        ({"start": [1.0, np.nan]}, r"start=\[1.0, nan\]: y: expected a finite number"),
        ({"start": [1, -1, 90]}, r"options: start=\[1, -1, 90\]: theta: radians, .*; 90 degrees are 1\.571 radians"),
        ({"goal": [9000, 0]}, "x: expected a number of at most 5000"),
        ({"goal": [1.0, 1.8, 0.0]}, r"give \[x, y\]"),
        ({"settings": {"route.speed": 1}}, "give 'key=value'"),
        ({"settings": "route.sped=1"}, "did you mean speed"),
        ({"settings": "lidar.model=urg04lx"}, r"lidar\.model cannot change"),
        ([0, 0], "give a dict"),
    ],
)
def test_unknown_options_do_not_end_the_episode(options: object, complaint: str) -> None:
    with P3DXEnv("paper_simulation") as env:
        env.reset(seed=0)
        with pytest.raises(InputError, match=complaint):
            env.reset(options=options)
        env.step(STRAIGHT)


def test_settings_need_a_scenario_name_or_file() -> None:
    scenario = load_scenario("paper_simulation")
    with pytest.raises(ScenarioError, match="the scenario is a value here"):
        P3DXEnv(scenario, "duration=3")
    with P3DXEnv(scenario) as env, pytest.raises(ScenarioError, match="the scenario is a value here"):
        env.reset(options={"settings": "duration=3"})


def test_a_string_is_a_list_of_one_item() -> None:
    env = P3DXEnv("paper_simulation", "duration=3", observe="scan", end_on="goal")
    assert env.scenario.duration == 3.0
    assert list(env.observation_space.spaces) == ["scan"]
    assert env.config.end_on == ("goal",)


def test_an_idle_env_is_copied_with_its_random_numbers() -> None:
    env = make(observe=("scan",), settings="duration=3")
    env.action_space.seed(4)
    copies = [env, copy.copy(env.unwrapped), copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    scans = []
    for each in copies:
        assert each.unwrapped.scenario.duration == 3.0
        assert each.unwrapped.spec.id == "hopslam/P3DX-v0"
        scans.append(each.reset(seed=2)[0]["scan"])
        each.close()
    np.testing.assert_array_equal(scans[1:], [scans[0]] * 3)
    np.testing.assert_array_equal(copies[2].action_space.sample(), copies[3].action_space.sample())


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_copying_a_running_env_names_the_alternative(copied: Callable[[object], object]) -> None:
    with P3DXEnv("paper_simulation") as env:
        env.reset(seed=0)
        with pytest.raises(InputError, match=r"close\(\) it first.*gymnasium\.make\(env\.spec\)"):
            copied(env)
        env.step(STRAIGHT)


def test_a_step_before_the_first_reset_is_refused() -> None:
    with pytest.raises(RobotError, match="call reset"):
        P3DXEnv("paper_simulation").step(STRAIGHT)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"reward": "progres"}, "argument reward: expected .*got 'progres'; did you mean progress"),
        ({"observe": ["scan", "depth"]}, r"argument observe\.1: expected 'scan', 'odometry', .*got 'depth'"),
        ({"colour": 3}, "argument colour: unknown key; known here: action, observe"),
        ({"observ": "scan"}, r"argument observ: unknown key; did you mean observe\?"),
        ({"cell": 0}, r"cell: expected a number of at least 0\.01 \(got 0\)"),
        ({"max_seconds": -1}, r"max_seconds: expected a number greater than 0 \(got -1\)"),
        ({"lost_beyond": "near"}, "lost_beyond: expected a number"),
        ({"scenario": "nowhere"}, "no scenario 'nowhere'"),
        ({"observe": "scann"}, r"got 'scann'; did you mean scan\?"),
        ({"observe": 3}, r"observe: expected a list of names \(got 3\)"),
        ({"observe": ()}, "observe: expected a list of 1 or more names"),
        ({"settings": "duration"}, "expected key=value"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, object], complaint: str) -> None:
    with pytest.raises(ScenarioError, match=complaint):
        P3DXEnv(**{"scenario": "paper_simulation"} | arguments)


def test_progress_reward_needs_a_route() -> None:
    with pytest.raises(ScenarioError, match=r"reward='progress' needs route\.waypoints"):
        P3DXEnv(Scenario(name="nowhere"))


def test_the_manual_lists_every_argument_with_its_default() -> None:
    for name, field in EnvConfig.model_fields.items():
        default = str(field.default).replace("'", '"') if not isinstance(field.default, str) else f'"{field.default}"'
        assert f"| `{name}` | `{default}` |" in str(P3DXEnv.__doc__)


@pytest.mark.parametrize(("limits", "last"), [({"settings": ["duration=1.0"]}, 9), ({"max_seconds": 0.55}, 4)])
def test_the_time_limit_truncates(limits: dict[str, object], last: int) -> None:
    with make(**limits) as env:
        env.reset(seed=0)
        for _ in range(last - 1):
            _, _, terminated, truncated, info = env.step(np.zeros(2))
            assert (terminated, truncated, info["ending"]) == (False, False, "")
        _, _, terminated, truncated, info = env.step(np.zeros(2))
    assert (terminated, truncated, info["ending"]) == (False, True, "time")
    assert info["seconds"] == pytest.approx(0.1 * (last + 1))


@pytest.mark.parametrize(("end_on", "ends"), [(["collision"], True), (["goal"], False)])
def test_a_collision_is_penalized_and_ends_if_configured(end_on: list[str], ends: bool) -> None:
    with make(end_on=end_on, collision_penalty=3.0) as env:
        env.reset(seed=0)
        for _ in range(40):
            _, reward, terminated, _, info = env.step(np.array([-1.2, 0.0]))
            if info["reward"]["collision"]:
                break
    assert info["reward"] == {"progress": pytest.approx(reward + 3.0), "collision": -3.0}
    assert (terminated, info["ending"]) == (ends, "collision" if ends else "")


def test_the_goal_terminates_and_progress_is_rewarded() -> None:
    scenario = load_scenario("paper_simulation", ["route.waypoints=[[1, 1.8]]"])
    with make(scenario=scenario, observe=["goal"]) as env:
        observation, info = env.reset(seed=0)
        assert observation["goal"] == pytest.approx([0.8, 0.0], abs=1e-3)
        left, rewards, terminated = info["route_left"], [], False
        while not terminated:
            _, reward, terminated, _, info = env.step(STRAIGHT)
            rewards.append(reward)
    assert info["ending"] == "goal"
    assert sum(rewards) == pytest.approx(left)


def test_being_lost_terminates() -> None:
    with make(end_on=["lost"], lost_beyond=0.001) as env:
        env.reset(seed=0)
        assert any(env.step(STRAIGHT)[2] for _ in range(30))
        assert env.unwrapped.episode.state.slam_error > 0.001
