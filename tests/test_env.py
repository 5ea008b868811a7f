"""The gymnasium environment: its conventions, and that it is the robot and nothing else."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sim  # noqa: F401 - registers the ids
from slam.odometry import Twist2D
from slam.run.scenario.file import load_scenario


@pytest.fixture
def env():
    with gymnasium.make("hopslam/P3DX-v0", scenario="paper_simulation") as env:
        yield env


def test_it_keeps_the_rules_of_gymnasium(env: gymnasium.Env) -> None:
    check_env(env.unwrapped, skip_render_check=True)


def test_it_is_found_without_an_import() -> None:
    code = (
        "import gymnasium, sys; env = gymnasium.make('sim:hopslam/P3DX-v0', scenario='corridor'); "
        "observation, info = env.reset(seed=1); print(observation['scan'].shape, info['observation'].T_map_base.x)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.startswith("(682,)")


def test_importing_sim_costs_no_pybullet() -> None:
    code = "import sim, sys; assert 'pybullet' not in sys.modules and 'sim.env' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def rollout(env: gymnasium.Env, seed: int) -> list[np.ndarray]:
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    seen = [observation["scan"], observation["odometry"]]
    for _ in range(30):
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        seen += [observation["scan"], observation["odometry"]]
        assert reward == 0.0
        assert not terminated
        assert not truncated
    return seen


def test_two_environments_with_one_seed_agree_bit_by_bit(env: gymnasium.Env) -> None:
    with gymnasium.make("hopslam/P3DX-v0", scenario="paper_simulation") as other:
        for mine, others in zip(rollout(env, 5), rollout(other, 5), strict=True):
            np.testing.assert_array_equal(mine, others)
    assert any((a != b).any() for a, b in zip(rollout(env, 5), rollout(env, 6), strict=True))


def test_resets_without_a_seed_differ(env: gymnasium.Env) -> None:
    env.reset(seed=1)
    scans = [env.reset()[0]["scan"] for _ in range(2)]
    assert (scans[0] != scans[1]).any()


def test_every_step_hands_out_fresh_arrays(env: gymnasium.Env) -> None:
    first, _ = env.reset(seed=0)
    kept = first["scan"].copy()
    env.step(np.array([0.5, 0.5], np.float32))
    np.testing.assert_array_equal(first["scan"], kept)


def test_the_observation_is_what_the_robot_saw(env: gymnasium.Env) -> None:
    env.reset(seed=0)
    observation, *_, info = env.step(np.array([9.0, 0.0], np.float32))
    seen = info["observation"]
    echoes = seen.scan.echoes
    np.testing.assert_allclose(observation["scan"][echoes], seen.scan.ranges[echoes], rtol=1e-6)
    assert (observation["scan"][np.isposinf(seen.scan.ranges)] == np.float32(seen.scan.range_max)).all()
    assert observation["odometry"][0] == pytest.approx(seen.odometry.T_odom_base.x)
    assert info["applied"] == Twist2D(1.2, 0.0)


def test_it_ends_with_the_duration() -> None:
    with gymnasium.make("hopslam/P3DX-v0", scenario="paper_simulation", settings=["duration=1.0"]) as env:
        env.reset(seed=0)
        ends = [env.step(np.zeros(2, np.float32))[2:4] for _ in range(10)]
    assert ends[:9] == [(False, False)] * 9
    assert ends[9] == (False, True)


def test_a_collision_terminates() -> None:
    scenario = load_scenario("paper_simulation", ["route.speed=1.0"])
    with gymnasium.make("hopslam/P3DX-v0", scenario=scenario) as env:
        env.reset(seed=0)
        assert any(env.step(np.array([-1.2, 0.0], np.float32))[2] for _ in range(50))
