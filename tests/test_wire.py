"""Recording of the wire: no byte is lost, listings match the protocols, and drivers accept a recording as a device."""

import ast
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.emulator.emulator import Emulator
from hardware.robot import HardwareRobot
from hardware.scip_line import ScipLine
from hardware.serial_port import PortLost, SerialPort
from hardware.wire.events import WireEvent, read_wire
from hardware.wire.listing import list_wire
from hardware.wire.messages import MessageSplitter
from hardware.wire.recorder import WireRecorder
from hardware.wire.session import WireSession
from slam.errors import InputError
from slam.odometry import Twist2D
from slam.scenario.file import load_scenario
from tests.rooms import room_plant

REAL = Path(__file__).parents[2] / "shared" / "data" / "real_urg04lx_hokuyoaist.txt"
"""Recorded traffic between a real URG-04LX and hokuyoaist."""
CHUNKS = st.lists(st.binary(min_size=1, max_size=40), max_size=12)
# Bytes that AriaCoda sends (ArRobotPacketSender), and what they mean.
ARIA = {
    "FA FB 06 0B 3B FA 00 05 3B": "VEL 250",
    "FA FB 06 0B 1B 96 00 A1 1B": "VEL -150",
    "FA FB 06 15 1B 19 00 2E 1B": "RVEL -25",
    "FA FB 06 20 3B 05 0F 25 4A": "VEL2 left 0.3 m/s, right 0.1 m/s",
    "FA FB 06 1C 3B 00 00 1C 3B": "SONAR 0",
    "FA FB 03 00 00 00": "SYNC0",
}


def written(path: Path, *events: WireEvent) -> Path:
    path.write_text("# hopslam wire 1\n" + "".join(event.line() for event in events))
    return path


def words(*events: WireEvent) -> list[str]:
    return [line.strip().split("  ", 3)[-1] for line in list_wire(events)]


@given(st.floats(0.0, 1e6), st.text(min_size=1).filter(lambda text: text.isprintable()), st.binary(max_size=99))
def test_a_log_line_describes_a_message(stamp: float, port: str, data: bytes) -> None:
    event = WireEvent(round(stamp, 6), port, "<", data)
    assert WireEvent.parse(event.line()) == event


@given(CHUNKS, st.data())
def test_a_truncated_file_keeps_the_earlier_messages(chunks: list[bytes], data: st.DataObject) -> None:
    lines = [WireEvent(float(k), "/dev/ttyS0", ">", chunk).line() for k, chunk in enumerate(chunks)]
    text = "".join(lines)
    cut = data.draw(st.integers(0, len(text)))
    whole = [event for event in map(WireEvent.parse, text[:cut].splitlines(keepends=True)) if event]
    assert [event.data for event in whole] == chunks[: len(whole)]
    assert len("".join(lines[: len(whole)])) <= cut
    assert len(whole) == len(chunks) or cut < len("".join(lines[: len(whole) + 1]))


@given(CHUNKS)
def test_no_byte_is_lost_in_messages(chunks: list[bytes]) -> None:
    splitter = MessageSplitter(b"\n")
    messages = [message for chunk in chunks for message in splitter.feed(chunk)] + list(splitter.flush())
    framing = {"arcos": 5, "ldrobot": 0, "scip": 0, "none": 0}
    found = sum(len(message.data) + framing[message.protocol] for message in messages)
    sent = b"".join(chunks)
    breaks = sent.count(b"\n") + sent.count(b"\r")
    assert len(sent) - breaks <= found + sum(message.data.count(b"\n") for message in messages) <= len(sent) + breaks


@pytest.mark.parametrize("hexadecimal", ARIA)
def test_bytes_of_aria_are_named(hexadecimal: str) -> None:
    data = bytes.fromhex(hexadecimal)
    events = [WireEvent(k / 100.0, "/dev/ttyUSB0", ">", data[k : k + 1]) for k in range(len(data))]
    assert words(*events) == [ARIA[hexadecimal]]


def test_the_packet_of_the_manual_of_the_ld19_is_named() -> None:
    packet = (
        "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 E2 C7 00 E9 C5 00 E5"
    )
    data = bytes.fromhex("99 31" + packet + "C2 00 E5 C0 00 E5 BE 82 3A 1A 50")
    lost, points = words(*(WireEvent(0.0, "p", "<", data[k : k + 9]) for k in range(0, len(data), 9)))
    assert lost == "2 bytes that are not a whole message: 99 31"
    assert (
        points
        == "points 324.27 to 334.70 deg clockwise, 12 echoes 0.192 to 0.224 m, 2152 deg/s, sensor's clock 6.714 s"
    )


def test_pulse_and_sync_are_told_apart() -> None:
    sent = ("FA FB 03 00 00 00", "FA FB 06 01 3B 01 00 02 3B", "FA FB 03 00 00 00", "FA FB 06 02 3B 01 00 03 3B")
    events = [WireEvent(k, "/dev/ttyUSB0", ">", bytes.fromhex(packet)) for k, packet in enumerate(sent)]
    assert words(*events) == ["SYNC0", "OPEN 1", "PULSE", "CLOSE 1"]


def test_damage_and_unknown_bytes_are_shown() -> None:
    wrong_sum = bytes.fromhex("FA FB 06 0B 3B FA 00 05 3C")
    assert words(WireEvent(0.0, "p", "<", wrong_sum)) == [
        "9 bytes that are not a whole message: fa fb 06 0b 3b fa 00 05 3c"
    ]
    half = WireEvent(0.0, "p", "<", b"MD0044072501000\n99b\nJU"), WireEvent(2.0, "p", "<", b"QT\n00P\n\n")
    first, second = words(*half)
    assert first.startswith("22 bytes that are not a whole message")
    assert second == "QT: status 00, done"


@pytest.fixture
def real(tmp_path: Path) -> Path:
    """The recording of the real sensor as a wire recording."""
    if not REAL.is_file():
        pytest.skip(f"no recording of a real sensor at {REAL}")
    events = []
    for line in REAL.read_text().splitlines():
        began, _, kind, data = line.split(maxsplit=3)
        events.append(WireEvent(float(began), "/dev/ttyACM0", kind, ast.literal_eval(data)))
    return written(tmp_path / "real.wire", *events)


def test_a_real_sensor_is_listed(real: Path) -> None:
    listed = "\n".join(list_wire(read_wire(real)))
    assert "SERI:H0706400" in listed
    assert "BM: status 02, the laser was on already" in listed
    assert "GD0044072501: scan of 682 ranges, 581 echoes" in listed  # 94 without an echo, 7 errors
    assert "whole message" not in listed
    assert "damaged" not in listed


def test_a_recording_answers_like_the_real_sensor(real: Path) -> None:
    line = ScipLine(SerialPort(f"wire:{real}", 19200), threading.Event())
    for command in ("PP", "VV", "GD0044072501", "VV"):  # in another order than was recorded
        assert line.ask_until_answered(command).echo == command
    assert line.ask("TM0", 0.2) is None
    line.send("GD0044072501")
    with pytest.raises(PortLost, match="the recording ends here"):
        line.wait_for("nothing", 5.0)


def drive(robot: HardwareRobot, scans: int) -> Iterator[tuple[np.ndarray, float]]:
    for _ in range(scans):
        robot.drive(Twist2D(0.3, 0.0))
        observation = robot.observe(5.0)
        assert observation is not None
        yield observation.scan.ranges, observation.odometry.T_odom_base.x


def test_a_recorded_drive_is_replayed(tmp_path: Path) -> None:
    record = tmp_path / "drive.wire"
    with Emulator(room_plant((-2.0, 3.5), (-2.0, 2.0), 0.16)) as emulator:
        scenario = load_scenario("corridor", emulator.port_settings)
        with HardwareRobot(scenario, yes=True, record_wire=record) as robot:
            driven = list(drive(robot, 20))  # more than are replayed, for a busy machine may miss some
    robot_port, lidar_port = scenario.hardware.robot_port, scenario.hardware.lidar_port
    ports = [f"hardware.robot_port=wire:{record}#{robot_port}", f"hardware.lidar_port=wire:{record}#{lidar_port}"]
    with HardwareRobot(load_scenario("corridor", ports), yes=True) as robot:
        again = list(drive(robot, 12))
    seen = {ranges.tobytes() for ranges, _ in driven}
    assert sum(ranges.tobytes() in seen for ranges, _ in again) >= 10
    assert max(x for _, x in again) == pytest.approx(max(x for _, x in driven[:15]), abs=0.2)
    with pytest.raises(InputError, match=f"choose wire:{record}#"):
        SerialPort(f"wire:{record}", 9600)


def test_both_directions_are_recorded(tmp_path: Path) -> None:
    with (
        WireSession(tmp_path / "emulator.wire") as wire,
        Emulator(room_plant((-2.0, 2.0), (-2.0, 2.0)), wire=wire) as emulator,
    ):
        port = SerialPort(emulator.robot.port.address, 9600)
        port.write(bytes.fromhex("FA FB 03 00 00 00"))
        assert port.read(5.0)
        port.close()
    kinds = [event.kind for event in read_wire(tmp_path / "emulator.wire")]
    assert kinds[:2] == [">", "<"]


def test_a_full_disk_ends_the_recording_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(InputError, match="choose another --record-wire FILE"):
        WireRecorder(Path("/dev/full"))
    with WireRecorder(tmp_path / "a.wire") as recorder:

        def full(*_: object) -> int:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(os, "write", full)
        recorder.add("p", "<", b"x")
        until = time.monotonic() + 10.0
        while not caplog.records and time.monotonic() < until:
            time.sleep(0.01)
        recorder.add("p", "<", b"y")
        monkeypatch.undo()
    assert "the wire is not recorded any more" in caplog.text
