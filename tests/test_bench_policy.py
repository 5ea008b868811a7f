"""One policy class runs on a batch, on one robot and on devices."""

import sys

import numpy as np
import pytest

from hardware.bench import policy_report, policy_scores
from hardware.bench.policy import POLICIES, GoalPolicy, make_policy
from slam.console.terminal import Terminal
from slam.errors import InputError

SEEDS = range(3, 5)


class Ahead:
    """A policy that drives straight ahead, for one robot or for many."""

    env_id = "hopslam/RandomOffice-v0"
    arguments = {"settings": "lidar.model=table1", "observe": "scan", "reward": "coverage", "max_seconds": 1.0}  # noqa: RUF012

    def __call__(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return np.broadcast_to(np.float32([0.5, 0.0]), (*observation["scan"].shape[:-1], 2))


class Short(GoalPolicy):
    """Drives to the goal for 4 s."""

    arguments = {**GoalPolicy.arguments, "max_seconds": 4.0}  # noqa: RUF012


def test_a_policy_has_a_score_in_every_simulator() -> None:
    """The goal is straight ahead: the reward of the first seconds is the same in every simulator."""
    batch = policy_scores.score_in_batch(Short(), SEEDS)
    plan, bullet = (policy_scores.score_alone(Short(), SEEDS, engine) for engine in ("plan", "bullet"))
    assert [score.ending for score in (*batch, *plan, *bullet)] == ["time"] * 6
    earned = np.array([[score.earned for score in scores] for scores in (batch, plan, bullet)])
    np.testing.assert_allclose(earned, earned[0, 0], atol=0.003)
    assert 1.0 < earned[0, 0] < 2.0


def test_the_table_includes_the_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pybullet", reason="no PyBullet")
    monkeypatch.setitem(POLICIES, "ahead", Ahead)
    table = policy_report.policy_table("ahead", SEEDS, 1, Terminal())
    assert [row[1] for row in table.rows] == ["2", "2", "2", "1", "1", "1"]
    assert all(float(row[2]) > 0.5 for row in table.rows)


def test_without_pybullet_the_table_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(POLICIES, "ahead", Ahead)
    monkeypatch.setitem(sys.modules, "pybullet", None)
    table = policy_report.policy_table("ahead", SEEDS, 0, Terminal())
    assert [row[:2] for row in table.rows] == [
        ("batch", "2"), ("physics.engine: plan", "2"), ("devices, moved by plan", "0"),
    ]  # fmt: skip
    assert "left out: PyBullet; PyBullet, only the seeds of devices; devices, moved by PyBullet." in table.notes


def test_a_wrong_policy_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match="no policy 'gaol'; did you mean goal"):
        make_policy("gaol")
    with pytest.raises(InputError, match="builtins:object: a policy has env_id"):
        make_policy("builtins:object")
