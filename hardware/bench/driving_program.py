"""A program that drives the emulated robot, as a user starts it."""

import os
import pty
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from slam.closing import Closing

if sys.platform != "linux":
    raise ImportError("hopslam bench hardware runs on Linux")

OWN_PROGRAM: Final = """
import sys, threading
from hardware.robot import HardwareRobot
from slam.odometry import Twist2D
from slam.scenario.file import load_scenario

def fail():
    sys.stdin.readline()
    raise ValueError("as told")

robot = HardwareRobot(load_scenario("corridor", sys.argv[1:]), yes=True).__enter__()  # never closed
threading.Thread(target=fail, daemon=True).start()
while True:
    robot.observe()
    robot.drive(Twist2D(0.3, 0.0))
"""
"""Source of a user's own program. Its arguments are settings; its second thread fails when a line arrives."""
_HOPSLAM: Final = "from slam.cli.main import main; main()"
_TAKE_TERMINAL: Final = "import os; os.close(os.open(os.ttyname(0), os.O_RDWR))\n"
"""Source that opens the terminal, which makes it the controlling terminal of the new session."""
_GRACE: Final = 20.0
"""Seconds that a program has to end after the request."""


class DrivingProgram(Closing):
    """Runs the command ``hopslam`` with these arguments, or Python source, on a new terminal or on pipes."""

    def __init__(self, words: Sequence[str], source: str = _HOPSLAM, on_terminal: bool = False) -> None:
        self._master, slave = pty.openpty()
        os.set_blocking(self._master, False)
        stream = slave if on_terminal else subprocess.PIPE
        source = _TAKE_TERMINAL + source if on_terminal else source
        command = [sys.executable, "-c", source, *words]
        self._process = subprocess.Popen(
            command, stdin=stream, stdout=stream, stderr=subprocess.STDOUT, start_new_session=True
        )
        os.close(slave)

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def send(self, number: int) -> None:
        """Send the program this signal."""
        self._process.send_signal(number)

    def write_line(self, line: str) -> None:
        """Write a line to the program's standard input, a pipe."""
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def drain(self) -> None:
        """Read the program's output on its terminal, which would fill up otherwise."""
        with suppress(OSError):  # nothing has arrived, or the program is gone
            os.read(self._master, 65536)

    def close_terminal(self) -> None:
        """Close the program's terminal window."""
        os.close(self._master)
        self._master = os.open(os.devnull, os.O_RDONLY)

    def close_output(self) -> None:
        """Stop reading the program's standard output and error, a pipe."""
        assert self._process.stdout is not None
        self._process.stdout.close()

    def wait(self) -> int | None:
        """Wait for the exit code, negative for the signal that killed the program; None if it does not end."""
        try:
            return self._process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            return None

    def close(self) -> None:
        """End the program, if it still runs, and free its streams."""
        for number in (signal.SIGCONT, signal.SIGTERM, signal.SIGKILL):
            if self._process.poll() is None:
                self.send(number)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        os.close(self._master)
