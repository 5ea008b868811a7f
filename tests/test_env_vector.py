"""Many environments at once, and videos of one."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.wrappers import RecordVideo

import sim  # noqa: F401  registers the ids

ID, SHORT = "hopslam/PaperSimulation-v0", {"max_seconds": 0.5, "reward": "coverage", "observe": ("scan", "slam_pose")}
LAST = 4
"""The step that truncates."""


def vector(kind: str, mode: AutoresetMode) -> VectorEnv:
    return gymnasium.make_vec(ID, num_envs=2, vectorization_mode=kind, vector_kwargs={"autoreset_mode": mode}, **SHORT)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("kind", ["sync", "async"])
def test_vector_modes_give_new_arrays_and_complete_infos(kind: str, mode: AutoresetMode) -> None:
    envs = vector(kind, mode)
    kept = []
    observations, infos = envs.reset(seed=[1, 2])
    for k in range(1, 8):
        if mode == AutoresetMode.DISABLED and k == LAST + 1:
            envs.reset(options={"reset_mask": np.array([True, True])})
        observations, _, _, truncated, infos = envs.step(np.full((2, 2), 0.5, np.float32))
        kept.append((observations["scan"], observations["scan"].copy()))
        assert truncated.all() == (k == LAST)
        assert infos["T_map_base"].shape == infos["slam_pose"].shape == (2, 3)
        assert infos["reward"]["coverage"].shape == (2,)
        if k == LAST and mode == AutoresetMode.SAME_STEP:
            final = [scan["scan"] for scan in infos["final_obs"]]
            kept += [(scan, scan.copy()) for scan in final]
            assert not np.array_equal(final[0], observations["scan"][0])
            assert list(infos["final_info"]["ending"]) == ["time", "time"]
        elif k == LAST:
            assert list(infos["ending"]) == ["time", "time"]
    envs.close()
    for array, copy in kept:
        np.testing.assert_array_equal(array, copy)


def test_two_vectorized_envs_equal_two_single_ones() -> None:
    envs = vector("sync", AutoresetMode.NEXT_STEP)
    envs.reset(seed=[1, 2])
    together, rewards, *_ = envs.step(np.full((2, 2), 0.5, np.float32))
    envs.close()
    for k, seed in enumerate((1, 2)):
        with gymnasium.make(ID, **SHORT) as alone:
            alone.reset(seed=seed)
            observation, reward, *_ = alone.step(np.full(2, 0.5, np.float32))
        np.testing.assert_array_equal(observation["scan"], together["scan"][k])
        assert reward == rewards[k]


def test_a_video_is_recorded(tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    env = RecordVideo(
        gymnasium.make(ID, render_mode="rgb_array", **SHORT), str(tmp_path / "video"), lambda episode: True
    )
    assert env.frames_per_sec == 10  # the video plays in simulated time
    env.reset(seed=0)
    while not any(env.step(np.full(2, 0.5, np.float32))[2:4]):
        pass
    env.close()
    assert [path.stat().st_size > 1000 for path in tmp_path.glob("video/*.mp4")] == [True]
