"""SLAM in a batch: each robot has the estimates of a single environment."""

import gymnasium
import numpy as np
import pytest

import sim  # noqa: F401  registers the ids
from slam.errors import InputError, RobotError

ID = "hopslam/ClutteredRoom-v0"
QUIET = ("physics.engine=plan", "lidar.noise=none", "robot.odometry.travel_noise=0")
KEYS = ("slam_pose", "slam_covariance", "slam_error", "slam_lost", "slam_odometry_only")


def batch(count: int, **arguments: object) -> gymnasium.vector.VectorEnv:
    return gymnasium.make_vec(ID, num_envs=count, vectorization_mode="vector_entry_point", **arguments)


def test_slam_in_a_batch_equals_that_of_one_environment() -> None:
    given = {"settings": QUIET, "observe": ("slam_pose", "map"), "end_on": ("collision", "lost")}
    envs, single = batch(2, slam=True, threads=1, **given), gymnasium.make(ID, **given)
    steps = np.random.default_rng(3).uniform([-0.2, -1.0], [0.5, 1.0], (12, 2, 2)).astype(np.float32)
    (seen, info), (alone, alone_info) = envs.reset(seed=1), single.reset(seed=1)
    for step in [None, *steps]:
        if step is not None:
            seen, _, ended, _, info = envs.step(step)
            alone, _, over, _, alone_info = single.step(step[0])
            assert ended[0] == over
        np.testing.assert_allclose(seen["slam_pose"][0], alone["slam_pose"], atol=1e-4)
        assert (seen["map"][0] == alone["map"]).mean() > 0.99
        for key in KEYS:
            np.testing.assert_allclose(info[key][0], alone_info[key], atol=1e-4)
    assert not (seen["slam_pose"][0] == seen["slam_pose"][1]).any()
    assert envs.observation_space.contains(seen)
    envs.close()
    single.close()


def test_episodes_with_slam_end_and_restart() -> None:
    """The number of beams varies, and a small error of SLAM counts as lost."""
    given = {"settings": ["lidar.model=ld19"], "observe": ("scan", "slam_pose"), "autoreset_mode": "SameStep"}
    envs = batch(2, slam=True, threads=1, end_on="lost", lost_beyond=0.04, max_seconds=0.4, **given)
    seen, info = envs.reset(seed=1)
    ends: list[str] = []
    for _ in range(4):
        seen, *_, info = envs.step(np.full((2, 2), 0.2))
        ends += info["final_info"]["ending"][info["_final_info"]].tolist() if "final_info" in info else []
        assert (info["slam_error"] < 0.1).all()
    assert ends == ["time", "time"]
    np.testing.assert_allclose(seen["slam_pose"], info["T_map_base"], atol=0.1)
    envs.unwrapped._slam._pool._processes[0].kill()
    with pytest.raises(RobotError, match="has ended; make a new environment"):
        envs.step(np.zeros((2, 2)))
    envs.close()


def test_slam_runs_only_if_enabled_and_needed() -> None:
    with pytest.raises(InputError, match="a batch runs SLAM only if told: add slam=True"):
        batch(2, observe=("scan", "slam_pose"))
    with pytest.raises(InputError, match="nothing here needs SLAM"):
        batch(2, slam=True)
