"""The benchmark of the simulator, on a few scans."""

import numpy as np
import pytest

from sim.bench import env_speed, report, speed
from sim.bench.memory import memory_growth
from sim.bench.planar_peer import PlanarPeer
from sim.bench.speed import corridor
from slam.console.terminal import Terminal
from slam.env.p3dx_env import P3DXEnv


@pytest.mark.parametrize("caster", ["bullet", "exact"])
def test_the_engine_and_the_whole_step_are_both_timed(caster: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "SCANS", 4)
    monkeypatch.setattr(speed, "ROUNDS", 2)
    measured = speed.speed_of(corridor(caster))
    assert measured.engine > 0.0
    assert measured.whole > 0.0
    assert measured.ours == 1.0 - measured.engine / measured.whole


def test_the_tables_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "speed_of", lambda _: speed.Speed(1e-3, 2e-3))
    monkeypatch.setattr(report, "reset_times", lambda _: (1e-4, 1e-2))
    monkeypatch.setattr(speed, "STEPS", 3)
    monkeypatch.setattr(report, "CASES", {"a wall": report.CASES["a wall at 0 degrees"]})
    monkeypatch.setattr(report, "SILLS", range(25, 27))
    monkeypatch.setattr(report, "memory_growth", lambda scenario, **_: memory_growth(scenario, 2, 1, 2))
    tables = report.sim_tables(True, Terminal(quiet=True))
    assert [len(table.rows) for table in tables] == [2, 2, 2, 1, 3, 2]
    assert tables[4].rows == [("over", "1", "25 to 25"), ("stopped", "1", "26 to 26"), ("hung", "0", "none")]
    assert tables[0].rows[0] == ("bullet", "1000", "2000", "50.0 %", "50")


def test_the_environments_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(env_speed, "ROUNDS", 1)
    paths, views, threads, slam = env_speed.env_tables(Terminal(quiet=True), (1, 3), 0.0, with_slam=())
    assert slam.rows == []
    assert [row[:2] for row in paths.rows] == [
        ("PyBullet, one robot", "1"), ("plan, one robot", "1"), ("batch", "1"), ("batch", "3"),
    ]  # fmt: skip
    assert [row[0].count(",") for row in views.rows] == [1, 2, 3]
    assert float(views.rows[0][3]) < 50.0
    assert threads.rows[0][0] == "1"


def test_the_other_simulator_sees_the_same_walls() -> None:
    pytest.importorskip("irsim", reason="pip install 'hopslam[bench]'")
    scenario = corridor("exact")
    peer, single = PlanarPeer(scenario), P3DXEnv(scenario, reward="none", end_on=())
    single.reset(seed=0)
    for _ in range(3):
        ranges = peer.step(np.zeros(2, np.float32))
        scan = single.step(np.zeros(2))[0]["scan"]
    assert (
        np.median(abs(ranges - scan)) < 0.25
    )  # the lidar is 16 cm ahead of the axle, that of the other simulator above it
    peer.close()
    single.close()
