"""Windows and macOS, which hopslam was not run on: simulated here, as far as a program can tell them from Linux."""

import errno
import fcntl
import json
import os
import select
import socket
import subprocess
import sys
from collections.abc import Callable
from itertools import repeat
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import hardware.usb_serial
from hardware.emulator.emulator import Emulator
from hardware.emulator.ports import TcpPort, pseudo_terminal
from hardware.keyboard import typed_line
from hardware.port_errors import reason_of
from hardware.stream_watch import StreamWatch
from hardware.usb_serial import listed_ports
from sim.plant import plan_plant
from slam.errors import InputError
from slam.files.disk import Disk
from slam.files.links import is_linked_file, link_file
from slam.run.results.run_folder import make_run_folder
from slam.scenario.file import load_scenario
from slam.scenario.hardware_config import HardwareConfig
from slam.system import is_running, reader_has_ended, usable_cores

RESERVED = set('<>:"|?*\\')
"""Characters that no file's name has on Windows."""
PROGRAM = """
import json, sys
from slam.cli.main import main

def hopslam(words):
    sys.argv = ["hopslam", *words]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, (words, ended.code)

if __name__ == "__main__":
    for words in json.loads(sys.argv[1]):
        hopslam(words)
"""
"""Runs several commands, each given by a list of words."""
SHORT = ["--set", "physics.engine=plan", "--set", "duration=0.5", "--set", "lidar.model=table1"]
COMMANDS = [
    ["run", "corridor", *SHORT],
    ["run", "corridor", *SHORT, "--seed", "1"],
    ["replay", "runs/latest", "--out", "again"],
    ["report", "runs/latest", "--out", "report.html"],
    ["animate", "runs/latest", "--out", "map.webp"],
    ["export", "runs/latest", "--to", "ros", "--out", "map"],
    ["repair", "runs/latest"],
    ["sweep", "corridor", "--seeds", "0:2", "--jobs", "2", *SHORT],
]
windows_only = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="this system does not tell what is open")


def on_windows(commands: list[list[str]], folder: Path) -> str:
    """Return what these commands print on a simulated Windows."""
    (folder / "program.py").write_text(PROGRAM)
    here = Path(__file__).parent
    path = os.pathsep.join([str(here / "windows"), str(here.parent)])
    done = subprocess.run(
        [sys.executable, "program.py", json.dumps(commands)], cwd=folder, capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": path, "PYTHONIOENCODING": "cp1252"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode("cp1252")


@windows_only
def test_windows_runs_replays_reports_exports_and_sweeps(tmp_path: Path) -> None:
    said = on_windows(COMMANDS, tmp_path)
    runs = sorted((tmp_path / "runs").iterdir())
    assert len(runs) == 3
    assert (tmp_path / "runs/latest").resolve() == runs[1]
    assert "2 runs done, 0 of them failed" in said
    assert b"\r" not in (tmp_path / "runs/latest/trajectory.tum").read_bytes()
    names = [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")]
    assert not [name for name in names if RESERVED & set(name) or name.endswith((".", " "))]
    assert len({name.casefold() for name in names}) == len(names)


@windows_only
def test_windows_drives_a_robot_over_tcp(tmp_path: Path) -> None:
    scenario = load_scenario("corridor", ["physics.engine=plan"])
    with Emulator(plan_plant(scenario), TcpPort(), TcpPort()) as emulator:
        ports = [word for setting in emulator.port_settings for word in ("--set", setting)]
        words = ["run", "corridor", "--backend", "hardware", "--yes", "--set", "duration=0.5", "--out", "run", *ports]
        assert "duration over" in on_windows([words], tmp_path)
        assert emulator.truth[1].x > 0.0


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Makes this process believe that it runs on Windows, with modules of these names and contents."""

    def be_windows(**modules: dict[str, object]) -> None:
        monkeypatch.setattr(sys, "platform", "win32")
        for name, content in modules.items():
            module = ModuleType(name)
            vars(module).update(content)
            monkeypatch.setitem(sys.modules, name, module)

    return be_windows


def test_a_line_typed_on_windows_ends_with_return(windows: Callable[..., None]) -> None:
    keys = iter("yes\rno")
    windows(msvcrt={"kbhit": lambda: True, "getwche": lambda: next(keys)})
    assert typed_line(lambda: False).strip() == "yes"
    assert typed_line(lambda: True) == ""


def refuse_process(*_: object) -> int:
    raise OSError(errno.EINVAL, "The parameter is incorrect")


@pytest.mark.parametrize(
    ("opening", "ended", "runs"),
    [(lambda *_: 7, 0, False), (lambda *_: 7, 258, True), (refuse_process, 0, False)],
)
def test_windows_is_asked_whether_a_process_runs(
    windows: Callable[..., None], opening: object, ended: int, runs: bool
) -> None:
    wait = {"WaitForSingleObject": lambda *_: ended, "WAIT_OBJECT_0": 0, "CloseHandle": lambda _: None}
    windows(_winapi={"OpenProcess": opening, **wait})
    assert is_running(1234) is runs


def test_windows_has_its_own_error_for_a_closed_pipe(windows: Callable[..., None]) -> None:
    assert not reader_has_ended(OSError(errno.EINVAL, "Invalid argument"))
    windows()
    assert reader_has_ended(OSError(errno.EINVAL, "Invalid argument"))
    assert reader_has_ended(OSError(errno.EPIPE, "Broken pipe"))


def test_a_file_that_is_open_on_windows_is_waited_for(
    windows: Callable[..., None], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "draft").write_text("new")
    replace, refusals = Path.replace, iter([PermissionError, PermissionError])

    def replace_later(draft: Path, path: Path) -> Path:
        for refusal in refusals:
            raise refusal
        return replace(draft, path)

    monkeypatch.setattr(Path, "replace", replace_later)
    windows()
    Disk().rename(tmp_path / "draft", tmp_path / "file")
    assert (tmp_path / "file").read_text() == "new"


def refuse_link(*_: object) -> None:
    raise PermissionError(errno.EPERM, "Operation not permitted")


def test_files_are_copied_without_the_right_to_make_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "symlink_to", refuse_link)
    (tmp_path / "file").write_text("text")
    link_file(tmp_path / "file", tmp_path / "lent")
    assert (tmp_path / "lent").read_text() == "text"
    assert is_linked_file(tmp_path / "lent")


def test_a_disk_without_links_has_no_latest_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "symlink_to", refuse_link)
    folder = make_run_folder("corridor", runs=tmp_path)
    assert list(tmp_path.iterdir()) == [folder]


NOT_FOUND = "could not open port 'COM7': FileNotFoundError(2, 'The system cannot find the file specified.', None, 2)"
IN_USE = "could not open port 'COM7': PermissionError(13, 'Access is denied.', None, 5)"
UNPLUGGED = "ClearCommError failed (PermissionError(13, 'The device does not recognize the command.', None, 22))"
WRONG_BAUD = "Cannot configure port, something went wrong. Original message: OSError(22, 'Wrong parameter.', None, 87)"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (NOT_FOUND, "there is no such port"),
        (IN_USE, "another program is using it"),
        (UNPLUGGED, "was it unplugged?"),
        (WRONG_BAUD, "Wrong parameter"),
    ],
)
def test_ports_of_windows_fail_with_a_next_step(windows: Callable[..., None], words: str, said: str) -> None:
    windows()
    assert said in reason_of("COM7", OSError(words))


@pytest.mark.parametrize(
    ("names", "likely"),
    [
        (["COM3", "COM12", "COM1"], ["COM3", "COM12"]),
        (
            ["/dev/cu.usbserial-1410", "/dev/cu.Bluetooth-Incoming-Port", "/dev/cu.usbmodem14201"],
            ["/dev/cu.usbmodem14201", "/dev/cu.usbserial-1410"],
        ),
    ],
)
def test_serial_ports_of_other_systems_are_listed(
    names: list[str], likely: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    ports = [SimpleNamespace(device=n, description=n, vid=0x0403 if n in likely else None) for n in names]
    monkeypatch.setattr(hardware.usb_serial, "comports", lambda: ports)
    assert [port.device for port in listed_ports() if port.likely] == likely


@pytest.mark.parametrize("name", ["COM3", r"\\.\COM12", "/dev/cu.usbserial-1410", "/dev/tty.usbmodem1"])
def test_port_names_of_each_system_are_accepted(name: str) -> None:
    assert HardwareConfig(robot_port=name).robot_port == name


def test_windows_has_no_pseudo_terminal(windows: Callable[..., None]) -> None:
    windows()
    with pytest.raises(InputError, match="give --tcp"):
        pseudo_terminal()


def test_macos_flushes_the_cache_of_the_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(fcntl, "F_FULLFSYNC", 51, raising=False)
    monkeypatch.setattr(fcntl, "fcntl", lambda _, command: asked.append(command))
    disk = Disk()
    with disk.open(tmp_path / "file") as file:
        disk.sync(file)
    assert asked == [51]


def test_macos_counts_all_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    assert usable_cores() == os.cpu_count()


class BlindPoll:
    """The poll of macOS, which does not watch terminals."""

    def __init__(self) -> None:
        self.watched: list[object] = []

    def register(self, stream: object, _events: int) -> None:
        self.watched.append(stream)

    def unregister(self, stream: object) -> None:
        self.watched.remove(stream)

    def poll(self, _timeout: float) -> list[tuple[object, int]]:
        return list(zip(self.watched, repeat(select.POLLNVAL), strict=False))


def test_a_terminal_not_watched_by_macos_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "isatty", lambda _: True)
    poll = BlindPoll()
    monkeypatch.setattr(select, "poll", lambda: poll)
    near, far = socket.socketpair()
    with near, far:
        StreamWatch(near)
        assert poll.watched == [near]
