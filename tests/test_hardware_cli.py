"""The commands of the devices: emulate, doctor, and run on the hardware back end."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hardware.bench.emulated_robot import emulated_robot, measure_load
from hardware.doctor import examine
from hardware.emulator.emulator import Emulator
from hardware.emulator.faults import TimedFault
from hardware.emulator.ports import TcpPort
from sim.plant import plan_plant
from slam.cli.main import main
from slam.errors import InputError
from slam.files.tum import read_tum
from slam.named_code import import_by_name
from slam.run.backends import make_plant
from slam.scenario.file import load_scenario


def command(*words: str) -> list[str]:
    return [sys.executable, "-c", "from slam.cli.main import main; main()", *words]


@pytest.fixture
def devices(tmp_path: Path) -> Iterator[dict[str, str]]:
    """Addresses of the devices of a running ``hopslam emulate``."""
    words = command("emulate", "corridor", "--link-dir", str(tmp_path / "robot"), "--fault", "robot:stall@60+1")
    words += ["--truth", str(tmp_path / "truth.tum")]
    environment = os.environ | {"PYTHONPATH": "."}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as program:
        assert program.stdout is not None
        yield json.loads(program.stdout.readline())
        program.send_signal(signal.SIGINT)
        assert program.wait(20) == 0
    assert not list((tmp_path / "robot").iterdir())


def test_a_run_on_emulated_devices(devices: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "run"
    settings = [f"hardware.robot_port={devices['p3dx']}", f"hardware.lidar_port={devices['urg04lx']}", "duration=1.5"]
    words = [word for setting in settings for word in ("--set", setting)]
    monkeypatch.setattr(
        sys, "argv", ["hopslam", "run", "corridor", "--backend", "hardware", "--yes", "--out", str(out), *words]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["ending"] == "duration over"
    assert metrics["scans"] >= 10
    stamps, poses = read_tum(tmp_path / "truth.tum")
    assert stamps[-1] - stamps[0] > 1.0
    assert poses[-1, 0] > 0.1


def test_load_and_latency_of_a_driving_robot_are_measured() -> None:
    with emulated_robot() as emulated:
        load = measure_load(emulated, 0.5)
        assert not emulated.standing
    assert load.scans >= 2
    assert load.cpu > 0.0
    assert load.latency_p99 >= load.latency_median


def test_doctor_examines_emulated_devices(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with Emulator(plan_plant(load_scenario("corridor")), TcpPort(), paced=False) as emulator:
        assert "robot emulated, class Pioneer, subclass p3dx-sh" in examine(emulator.robot.port.address, 19200).words
        picture = tmp_path / "scan.png"
        monkeypatch.setattr(sys, "argv", ["hopslam", "doctor", emulator.lidar.port.address, "--png", str(picture)])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 0
        said = capsys.readouterr().out
        assert "URG-04LX" in said
        assert "10 scans a second of 682 beams" in said
        assert picture.stat().st_size > 10_000
        assert not emulator.urg04lx.laser
    assert "no such port" in examine("/dev/there-is-none", 19200).words


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--dry-run"], "add --backend hardware"),
        (["--backend", "replay"], "run: hopslam replay LOG"),
        (["--backend", "hardwear"], "did you mean hardware?"),
        (["--backend", "hardware", "--set", "lidar.model=table1"], "set lidar.model=urg04lx"),
    ],
)
def test_unsuitable_options_are_refused(
    words: list[str],
    complaint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["hopslam", "run", "corridor", "--out", str(tmp_path / "run"), *words])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_planned_faults_are_read() -> None:
    assert TimedFault.parse("lidar:unplug@10+5") == TimedFault("lidar", "unplug", 10.0, 5.0)
    assert TimedFault.parse("robot:e-stop@3") == TimedFault("robot", "e-stop", 3.0, None)
    for text in ("lidar:e-stop@3", "lidar:unplug", "robot:stall@x"):
        with pytest.raises(InputError, match="expected for example"):
            TimedFault.parse(text)


def test_planned_faults_happen() -> None:
    emulator = Emulator(plan_plant(load_scenario("corridor")))
    for text in ("robot:e-stop@0.05+600", "lidar:dead@0", "lidar:unplug@0+0.01", "robot:motors-off@0+0"):
        TimedFault.parse(text).schedule(emulator)
    with emulator:
        while not (emulator.p3dx.motors.e_stop and emulator.urg04lx.dead):
            import_by_name("time:sleep")(0.01)
        assert emulator.lidar.port.filenos()


def test_an_empty_world_cannot_be_emulated() -> None:
    with pytest.raises(InputError, match="nothing to see"):
        make_plant("plan", load_scenario("replay"))
    with pytest.raises(InputError, match="no plant named 'pan'; did you mean plan"):
        make_plant("pan")
