"""Battery, faults and sonar of the base, from the packet to the summary."""

import json
import logging
import sys
from math import hypot, inf, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import P3DX_SH
from hardware.arcos.sip import Sip
from hardware.battery_watch import BatteryWatch
from hardware.emulator.emulator import Emulator
from slam.cli.main import main
from slam.run.results.metrics import measure
from slam.run.results.step_table import read_steps
from slam.scenario.hardware_config import HardwareConfig
from slam.sonar_ring import FRONT, TRANSDUCERS, echo_points
from tests.rooms import room_plant


def watched(volts: list[float], settings: ArcosConfig = ArcosConfig()) -> list[str]:  # noqa: B008  # frozen
    """Levels after each of these voltages, ten a second."""
    watch, levels = BatteryWatch(HardwareConfig(), settings), list[str]()
    for k, value in enumerate(volts):
        watch.take(k / 10.0, value)
        levels.append("unknown" if watch.state is None else watch.state.level)
    return levels


@given(st.lists(st.floats(0.0, 30.0), max_size=29))
def test_short_voltage_dips_are_ignored(volts: list[float]) -> None:
    assert set(watched([12.6, *volts, 12.6])) <= {"good"}


def test_battery_is_low_and_then_empty(caplog: pytest.LogCaptureFixture) -> None:
    levels = watched([12.5] * 10 + [11.4] * 40 + [10.9] * 40)
    assert [levels.count(level) for level in ("good", "low", "empty")] == [10 + 30, 10 + 30, 10]
    assert levels == sorted(levels, key=["good", "low", "empty"].index)
    assert [record.message for record in caplog.records if record.levelno == logging.WARNING] == [
        "the robot's battery is low: 11.4 V; at 11.0 V the robot stops: bring it home and charge it"
    ]


def test_the_higher_of_both_voltage_limits_is_used() -> None:
    settings = ArcosConfig(low_battery=12.0, shutdown_voltage=11.5)
    assert watched([11.8] * 40, settings)[-1] == "low"
    assert watched([11.6] * 40, settings)[-1] == "empty"
    assert watched([0.0] * 40)[-1] == "unknown"


def test_a_report_has_battery_and_faults() -> None:
    head = "32 0000 0000 0000 0000 0000 71 0000 0000 0100 00 00 00 00 00 00 00"  # byte 11: 0x71 = 11.3 V
    assert Sip.decode(bytes.fromhex(head), P3DX_SH).volts == pytest.approx(11.3)
    tail = "7D00 00 0000 0400"  # battery x 10 = 125, charge state, rotational velocity, fault flags
    sip = Sip.decode(bytes.fromhex(head + tail), P3DX_SH)
    assert (sip.volts, sip.faults) == (pytest.approx(12.5), 4)


@given(st.lists(st.floats(0.1, 5.0) | st.just(inf), min_size=8, max_size=16))
def test_echoes_lie_ahead_of_their_transducers(ranges: list[float]) -> None:
    points = echo_points(ranges)
    heard = [k for k, metres in enumerate(ranges) if metres < inf]
    assert len(points) == len(heard)
    for (x, y), k in zip(points, heard, strict=True):
        assert hypot(x - TRANSDUCERS[k, 0], y - TRANSDUCERS[k, 1]) == pytest.approx(ranges[k])


def test_the_rings_are_symmetric() -> None:
    mirrored = TRANSDUCERS[:FRONT][::-1] * np.array([1.0, -1.0, -1.0])
    assert mirrored == pytest.approx(TRANSDUCERS[:FRONT])
    assert np.abs(TRANSDUCERS[FRONT:, 2]).min() == pytest.approx(pi / 2)


def test_an_empty_battery_ends_the_run_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    with Emulator(room_plant((-2.0, 30.0), (-2.0, 2.0), 0.16), paced=False) as emulator:
        emulator.do(lambda: emulator.p3dx.set_battery(10.8))
        words = [word for setting in [*emulator.port_settings, "duration=60"] for word in ("--set", setting)]
        arguments = ["hopslam", "run", "corridor", "--backend", "hardware", "--yes", "--out", str(out), *words]
        monkeypatch.setattr(sys, "argv", arguments)
        with pytest.raises(SystemExit) as ended:
            main()
        assert not emulator.p3dx.motors.moving
    assert ended.value.code == 3
    said = capsys.readouterr()
    assert "battery empty; results in" in said.out
    assert said.err.splitlines()[-1].startswith("hopslam: the battery is down to 10.8 V, so the robot was stopped")
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["ending"] == "battery empty"
    assert metrics["battery_end_v"] == 10.8
    assert measure(out)["stalled_scans"] == 0
    steps, fault = read_steps(out / "steps.csv")
    assert fault is None
    assert set(steps["battery"]) == {10.8}
    assert np.isnan(steps["sonar_nearest"]).all()
