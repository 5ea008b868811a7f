"""Closed standard output: the run completes, and the exit code reports the loss."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from slam.console.robust_output import RobustFile

MAIN = [sys.executable, "-c", "from slam.cli.main import main; main()"]
SHORT = ["run", "corridor", "--set", "duration=1", "--set", "physics.engine=plan", "--set", "slam.mode=dead_reckoning"]
CLOSE = "import os, sys; os.close(1); os.execv(sys.executable, [sys.executable, *sys.argv[1:]])"
"""Python source that closes standard output and becomes another program."""


def start(words: list[str], stdout: int) -> subprocess.Popen[str]:
    return subprocess.Popen([*MAIN, *words], stdout=stdout, stderr=subprocess.PIPE, text=True)


def end(program: subprocess.Popen[str]) -> tuple[int, str]:
    _, errors = program.communicate(timeout=120.0)
    return program.returncode, errors


def assert_complete(folder: Path) -> None:
    assert json.loads((folder / "metrics.json").read_text())["scans"] > 5
    assert (folder / "map.png").stat().st_size > 10_000
    assert (folder / "log.mcap").read_bytes().startswith(b"\x89MCAP")


def test_a_reader_that_has_ended_does_not_end_the_run(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    code, errors = end(start([*SHORT, "--out", str(tmp_path / "run")], writer))
    os.close(writer)
    assert (code, errors) == (128 + signal.SIGPIPE, "")
    assert_complete(tmp_path / "run")


def test_closed_output_does_not_end_the_run(tmp_path: Path) -> None:
    words = [sys.executable, "-c", CLOSE, *MAIN[1:], *SHORT, "--out", str(tmp_path / "run")]
    ended = subprocess.run(words, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr == "hopslam: standard output: it was closed; what was printed is not complete\n"
    assert_complete(tmp_path / "run")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_is_named() -> None:
    with Path("/dev/full").open("w") as full:
        code, errors = end(start(["schema"], full.fileno()))
    assert code == 1
    assert errors == "hopslam: standard output: No space left on device; what was printed is not complete\n"


def test_a_wrong_command_keeps_its_exit_code_without_output() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    code, errors = end(start(["run", "no_such_scenario"], writer))
    os.close(writer)
    assert code == 2
    assert "no_such_scenario" in errors


def test_a_file_takes_everything_after_its_first_error() -> None:
    reader, writer = os.pipe()
    with RobustFile(writer) as file:
        assert file.write(b"one") == 3
        os.close(reader)
        assert file.write(b"two") == 3
        assert file.write(b"three") == 5
        assert file.error is not None
        assert file.error.errno == errno.EPIPE
