"""``hopslam doctor``: reports of devices, and messages on ports that cannot be used."""

import errno
import os
import pty
import socket
import sys
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

import hardware.usb_serial
from hardware.doctor import examine
from hardware.emulator.emulator import Emulator
from hardware.emulator.ports import TcpPort
from hardware.port_errors import reason_of
from hardware.serial_port import PortLost, SerialPort
from hardware.usb_serial import latency_timer, listed_ports
from sim.plant import plan_plant
from slam.cli.main import main
from slam.scenario.file import load_scenario

# Answers of a real URG-04LX. A sum follows each line (C-42-03320B): that of its bytes, & 0x3f, + 0x30.
INFORMATION = {
    "VV": "VEND:Hokuyo\nPROD:URG-04LX\nFIRM:3.1.04\nPROT:SCIP 2.0\nSERI:H1",
    "PP": "MODL:URG-04LX\nDMIN:20\nDMAX:5600\nARES:1024\nAMIN:44\nAMAX:725\nAFRT:384\nSCAN:600",
    "II": "MODL:URG-04LX\nLASR:OFF\nSCSP:600\nMESM:CLASSIC\nSBPS:19200\nTIME:000000\nSTAT:Sensor works well.",
}


def with_sum(text: str) -> str:
    return text + chr((sum(text.encode()) & 0x3F) + 0x30)


def lidar_answer(command: str, statuses: dict[str, str], state: str) -> str:
    letters = command[:2]
    status = statuses.get(letters, "00" if letters in (*INFORMATION, "QT", "BM") else "0E")
    text = INFORMATION.get(letters, "") if status == "00" else ""
    text = text.replace("Sensor works well.", state)
    lines = "".join(f"{line};{with_sum(line)[-1]}\n" for line in text.splitlines())
    return f"{command}\n{with_sum(status)}\n{lines}\n"


@contextmanager
def serving(answer: Callable[[str], str]) -> Iterator[SimpleNamespace]:
    """A pseudo-terminal on which every line is answered; ``heard`` are the lines."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    served = SimpleNamespace(port=os.ttyname(slave), heard=[])

    def serve() -> None:
        pending = b""
        while data := os.read(master, 4096):
            *lines, pending = (pending + data).split(b"\n")
            for line in filter(None, lines):
                served.heard.append(line.decode("latin-1"))
                os.write(master, answer(served.heard[-1]).encode("latin-1"))
            if pending.endswith(b"\0stop"):
                return

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield served
    finally:
        os.write(slave, b"\0stop")
        thread.join()
        os.close(master)
        os.close(slave)


@pytest.mark.parametrize(
    ("statuses", "state", "said"),
    [
        ({"BM": "01"}, "Sensor works well.", "the laser is faulty (BM, status 01)"),
        ({"GD": "50"}, "Sensor works well.", "status 50, the sensor has a hardware fault"),
        ({"BM": "01"}, "Laser malfunction", '"Laser malfunction"'),
    ],
)
def test_doctor_prints_the_report_of_a_lidar(statuses: dict[str, str], state: str, said: str) -> None:
    with serving(lambda command: lidar_answer(command, statuses, state)) as lidar:
        finding = examine(lidar.port, 500000)
    assert "serial number H1" in finding.words
    assert any(said in fault for fault in finding.faults)
    assert not finding.fine
    assert lidar.heard[-1] == "QT"


def test_doctor_prints_the_report_of_a_robot() -> None:
    with Emulator(plan_plant(load_scenario("corridor")), TcpPort(), paced=False) as emulator:
        assert emulator.truth  # its loops are compiled now
        port = emulator.robot.port.address
        assert examine(port, 19200).fine
        emulator.do(lambda: emulator.p3dx.motors.press_e_stop(True))
        finding = examine(port, 19200)
        assert finding.faults == ("its emergency stop is pressed; release it",)
        assert not emulator.p3dx.open


def refused() -> str:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"socket://127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("socket://robot", "a port over the network is socket://HOST:NUMBER"),
        ("socket://robot:99999", "a port over the network is socket://HOST:NUMBER"),
        ("socket://robot.invalid:4001", "no host is called robot.invalid"),
        pytest.param(refused(), "nobody listens there", id="refused"),  # another port in each process
        ("/dev/null", "this is not a serial port"),
        ("/", "this is not a serial port"),
        ("/dev/there-is-none", "there is no such port"),
    ],
)
def test_a_wrong_port_is_one_line_and_exit_code_3(
    port: str, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["hopslam", "doctor", port])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 3
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(f"{port}: {said}")


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (errno.EACCES, "run: sudo usermod -aG"),
        (errno.EBUSY, "another program is using it"),
        (errno.EHOSTUNREACH, "the host does not answer"),
        (errno.ETIMEDOUT, "the host does not answer"),
    ],
)
def test_system_errors_name_a_next_step(number: int, said: str) -> None:
    hidden = OSError("could not open port")  # as pyserial hides it
    hidden.__context__ = OSError(number, os.strerror(number))
    assert said in reason_of("/dev/ttyUSB0", hidden)


def test_a_port_in_use_is_reported() -> None:
    master, slave = pty.openpty()
    first = SerialPort(os.ttyname(slave), 9600)
    with pytest.raises(PortLost, match="another program is using it"):
        SerialPort(os.ttyname(slave), 9600)
    first.close()
    os.close(master)
    os.close(slave)


def test_only_likely_ports_are_examined(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    connected = [
        SimpleNamespace(device="/dev/ttyACM9", description="Arduino Uno", vid=0x2341),
        SimpleNamespace(device="/dev/ttyS9", description="n/a", vid=None),
        SimpleNamespace(device="/dev/ttyUSB9", description="FT232R USB UART", vid=0x0403),
    ]
    monkeypatch.setattr(hardware.usb_serial, "comports", lambda: connected)
    assert [port.likely for port in listed_ports()] == [False, False, True]
    monkeypatch.setattr(sys, "argv", ["hopslam", "doctor"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 3  # none was found
    said = capsys.readouterr().out
    assert "/dev/ttyACM9: Arduino Uno, left alone" in said
    assert "/dev/ttyUSB9: there is no such port" in said


def test_the_latency_timer_is_found_through_a_symbolic_link(tmp_path: Path) -> None:
    timer = tmp_path / "ttyUSB3" / "latency_timer"
    timer.parent.mkdir()
    timer.write_text("16\n")
    (tmp_path / "p3dx").symlink_to(tmp_path / "dev" / "ttyUSB3")
    found = latency_timer(str(tmp_path / "p3dx"), tmp_path)
    assert found is not None
    assert found.milliseconds == 16
    assert f"run: echo 1 | sudo tee {timer}" in str(found.advice)
    timer.write_text("1\n")
    again = latency_timer(str(tmp_path / "p3dx"), tmp_path)
    assert again is not None
    assert again.advice is None
    assert latency_timer("/dev/ttyACM0", tmp_path) is None
