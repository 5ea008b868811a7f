"""The examples of docs/examples that learn from a batch; they need the extra rl."""

import importlib
import runpy
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "docs/examples"


def load(name: str, module: str, monkeypatch: pytest.MonkeyPatch) -> object:
    """Import an example, where the package that it needs is installed."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own imports
        pytest.importorskip(module, reason="pip install 'hopslam[rl]'")
        return importlib.import_module(name)


def test_a_policy_drives_one_robot_as_it_drives_many(monkeypatch: pytest.MonkeyPatch) -> None:
    explorer = load("explorer", "gymnasium", monkeypatch)
    envs, policy = explorer.explorers(5, offices=2), explorer.ByHand()
    observation, _ = envs.reset(seed=0)
    envs.close()
    actions = policy(observation)
    assert actions.shape == (5, 2)
    for k in range(5):
        np.testing.assert_array_equal(actions[k], policy({name: rows[k] for name, rows in observation.items()}))


def test_the_batch_is_a_vec_env_of_stable_baselines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Observations are those of the batch; at the end of an episode its last one is in ``infos``."""
    explorer = load("explorer", "gymnasium", monkeypatch)
    adapter = load("batch_vec_env", "stable_baselines3.common.vec_env", monkeypatch)
    envs, same = explorer.explorers(3, offices=2), explorer.explorers(3, offices=2)
    wrapped = adapter.BatchVecEnv(envs, explorer.sectors, explorer.SPACE)
    wrapped.seed(4)
    np.testing.assert_array_equal(wrapped.reset(), explorer.sectors(same.reset(seed=4)[0]))
    ends = 0
    for _ in range(150):
        seen, rewards, over, infos = wrapped.step(np.full((3, 2), 0.7, np.float32))
        expected, earned, terminated, truncated, info = same.step(np.full((3, 2), 0.7, np.float32))
        np.testing.assert_array_equal(seen, explorer.sectors(expected))
        np.testing.assert_allclose(rewards, earned, rtol=1e-6)
        np.testing.assert_array_equal(over, terminated | truncated)
        for k in np.flatnonzero(over):
            ends += 1
            last = explorer.sectors(info["final_obs"][k])
            np.testing.assert_array_equal(infos[k]["terminal_observation"], last)
            assert infos[k]["TimeLimit.truncated"] == truncated[k]
    assert ends > 0
    wrapped.close()
    same.close()


def test_tensors_share_the_memory_of_the_batch(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    example = load("torch_batch", "torch", monkeypatch)
    monkeypatch.setattr(example, "ROBOTS", 4)
    monkeypatch.setattr(example, "STEPS", 3)
    example.main()
    assert "steps a second" in capsys.readouterr().out


def test_without_pytorch_the_package_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(SystemExit):
        runpy.run_path(str(EXAMPLES / "torch_batch.py"))
    assert capsys.readouterr().err == "torch_batch.py needs PyTorch: pip install 'hopslam[rl]'\n"
