"""Devices with the quirks that owners report: they work, or the error names the quirk."""

import logging
import threading

import numpy as np
import pytest

from hardware.arcos.model import units_of
from hardware.arcos.sip import Sip
from hardware.p3dx import P3dx
from hardware.scip_line import ScipLine
from hardware.scip_session import connect_lidar, identify
from hardware.serial_port import SerialPort
from hardware.urg04lx import Urg04lx
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.lidars import URG04LX
from slam.scenario.hardware_config import FlashSettings, HardwareConfig
from slam.scenario.robot_config import Limits
from tests.scripted_devices import LIDAR, VERSION, config, device, entries, lidar, packet, robot, scip, sip

OK = scip("00")


@pytest.fixture(autouse=True)
def quick_and_heard(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    caplog.set_level(logging.WARNING)
    monkeypatch.setattr("hardware.arcos_session.ANSWER", 0.1)  # these robots answer at once, or never


def open_robot(on_config: bytes, settings: FlashSettings | None = None, subclass: str = "p3dx-sh") -> None:
    with device(robot(subclass, on_config)) as url:
        hardware = HardwareConfig(robot_port=url, settings=settings or FlashSettings())
        P3dx(hardware, Limits(), threading.Event(), WireSession()).close()


def test_a_robot_without_a_settings_report_is_accepted(caplog: pytest.LogCaptureFixture) -> None:
    open_robot(b"", FlashSettings(watchdog=0.4))
    assert "does not report its settings (CONFIG); hardware.settings is used: a watchdog of 0.4 s" in caplog.text
    caplog.clear()
    open_robot(packet(config(800)[:-2]))  # old firmware, whose packet ends before the watchdog
    assert "a watchdog of 2 s" in caplog.text
    with pytest.raises(RobotError, match=r"does not report its settings|watchdog is 3 s"):
        open_robot(b"", FlashSettings(watchdog=3.0))


def test_settings_with_a_wrong_checksum_are_asked_twice(caplog: pytest.LogCaptureFixture) -> None:
    open_robot(packet(config(800), wrong=1))
    assert "wrong checksum, but arrived twice alike" in caplog.text
    assert "stops it after 0.8 s" in caplog.text
    with pytest.raises(RobotError, match="watchdog is off"):
        open_robot(packet(config(0), wrong=1))


@pytest.mark.parametrize(
    ("subclass", "distance", "speed", "turning"),  # DistConvFactor, VelConvFactor, DiffConvFactor of params/*.p
    [
        ("p3dx", 0.485, 1.0, 0.0056),
        ("p3dx-sh-lms500", 1.0, 1.0, 0.0056),
        ("p3at", 0.465, 1.0, 0.0034),
        ("P3AT-SH", 1.0, 1.0, 0.0034),
        ("amigo", 0.5083, 0.6154, 0.011),
        ("amigo-sh", 1.0, 1.0, 0.011),
        ("perfpb+", 0.485, 1.0, 0.006),
        ("peoplebot-sh", 1.0, 1.0, 0.006),
    ],
)
def test_each_robot_model_has_its_units(subclass: str, distance: float, speed: float, turning: float) -> None:
    units = units_of(subclass)
    assert units is not None
    report = Sip.decode(sip(x=1000, left=-200, right=200)[3:-2], units)
    assert report.x == pytest.approx(distance)
    assert (report.left, report.right) == pytest.approx((-0.2 * speed, 0.2 * speed))
    assert 1.0 / units.half_track == pytest.approx(1000.0 * turning)


def test_a_robot_with_unknown_units_is_refused() -> None:
    with pytest.raises(RobotError, match="'powerbot-sh' are unknown; known are p3dx,"):
        open_robot(packet(config(800)), subclass="powerbot-sh")


def identity_and_beams(answers: dict[str, str]) -> tuple[str, int]:
    with device(lidar(LIDAR | answers)) as url:
        line = ScipLine(SerialPort(url, 115200), threading.Event())
        connect_lidar(line, 115200)
        version, parameters = identify(line)
        line.port.close()
    return version.serial_number, parameters.lidar.beams


@pytest.mark.parametrize(
    ("answer", "serial_number"),
    [
        (f"VV\n{OK}\n{VERSION[:-2]}!\n\n", "H1"),  # the last sum is wrong
        (f"VV\n{OK}\n{VERSION.replace('PROD', chr(10) + 'PROD')}\n", "unknown"),  # a line feed too many
        (f"VV\n{scip('0E')}\n\n", "unknown"),
        (f"VV\n{OK}\n{entries(VEND='Hokuyo')}\n", "unknown"),
    ],
)
def test_a_damaged_identity_is_only_a_warning(
    answer: str, serial_number: str, caplog: pytest.LogCaptureFixture
) -> None:
    assert identity_and_beams({"VV": answer}) == (serial_number, 682)
    assert "its answer to VV is damaged, or a refusal" in caplog.text


@pytest.mark.parametrize("status", ["0E", "10"])  # of a URG-04LX, and of urg_sim
def test_a_sensor_left_in_time_mode_is_freed(status: str) -> None:
    answers = dict(LIDAR)

    class Freed(dict[str, str]):
        def get(self, command: str, default: str = "") -> str:  # type: ignore[override]
            if command == "TM2":
                self["QT"] = LIDAR["QT"]
                return f"TM2\n{OK}\n\n"
            return super().get(command, default)

    with device(lidar(Freed(answers | {"QT": f"QT\n{scip(status)}\n\n"}))) as url:
        line = ScipLine(SerialPort(url, 115200), threading.Event())
        connect_lidar(line, 115200)
        line.port.close()


@pytest.mark.parametrize("unknown", ["E", ""])  # its answer to unknown commands; "": none
def test_firmware_that_is_too_old_is_named(unknown: str) -> None:
    old = "V\n0\nVEND:Hokuyo\nPROD:URG-04LX\nFIRM:2.2.01\nPROT:1.1\nSERI:H1\n\n"
    with device(lidar({"V": old}, unknown)) as url:
        line = ScipLine(SerialPort(url, 115200), threading.Event())
        with pytest.raises(RobotError, match=r"firmware, 2\.2\.01, speaks SCIP 1 only: update the firmware"):
            connect_lidar(line, 115200)
        line.port.close()


def open_lidar(url: str) -> Urg04lx:
    return Urg04lx(HardwareConfig(lidar_port=url), URG04LX, threading.Event(), WireSession())


def test_a_sensor_that_refuses_to_stop_is_named() -> None:
    with (
        device(lidar(LIDAR | {"QT": f"QT\n{scip('0L')}\n\n"})) as url,
        pytest.raises(RobotError, match="does not stop: status 0L to QT"),
    ):
        open_lidar(url)


def test_a_faulty_laser_is_named() -> None:
    with (
        device(lidar(LIDAR | {"BM": f"BM\n{scip('01')}\n\n"})) as url,
        pytest.raises(RobotError, match="the laser is faulty"),
    ):
        open_lidar(url)


def test_a_sensor_without_single_scans_works() -> None:
    with device(lidar(LIDAR)) as url:
        sensor = open_lidar(url)
        scan = sensor.scans.take(20.0)
        sensor.close()
    assert scan is not None
    assert np.array_equal(scan.ranges, np.full(682, 1.0))


def test_a_sensor_that_sends_nothing_is_asked_why() -> None:
    refusal = {"GD0044072501": f"GD0044072501\n{scip('50')}\n\n"}
    with (
        device(lidar(LIDAR | refusal, scans=False)) as url,
        pytest.raises(RobotError, match="sends no scans: status 50 to GD0044072501, the sensor has a hardware fault"),
    ):
        open_lidar(url)
