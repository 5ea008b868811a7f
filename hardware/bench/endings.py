"""Benchmark of endings: time until a robot is told to stop, and stops, after its program ends or is suspended."""

import resource
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from operator import methodcaller
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from hardware.bench.driving_program import OWN_PROGRAM, DrivingProgram
from hardware.bench.emulated_robot import FORWARD, emulated_devices, seconds_until
from hardware.emulator.emulator import Emulator
from slam.errors import RobotError
from slam.scenario.file import load_scenario

if sys.platform != "linux":
    raise ImportError("hopslam bench hardware runs on Linux")

_STANDING: Final = 0.01
"""Speed below which a robot counts as at rest, m/s."""
_WATCHED: Final = 1.5
"""Seconds for which the robot is watched after the ending."""
_START: Final = 60.0
"""Seconds that a program has until its robot moves."""


@dataclass(frozen=True, slots=True)
class Ending:
    """Event that ends or suspends a program, and the kind of program that it happens to."""

    name: str
    action: Callable[[DrivingProgram], None]
    own_program: bool = False
    """True for a user's own program, False for ``hopslam run``."""
    on_terminal: bool = False
    """True for a program on a terminal, False for one on pipes."""


@dataclass(frozen=True, slots=True)
class EndingResult:
    """Outcome of an ending; seconds are counted from it, None for never."""

    name: str
    to_command: float | None
    """Seconds until a command to stop had arrived."""
    to_stand: float | None
    """Seconds until the robot had come to rest for good."""
    distance: float
    """Metres driven after the ending."""
    exit_code: int | None
    """Exit code, negative for a signal; None while the program still runs."""
    recorded: bool
    """True if the run's folder has its metrics."""


def _fill_disk(program: DrivingProgram) -> None:
    """Forbid the program to make any file longer, as on a full disk."""
    resource.prlimit(program.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))


def _suspend_and_resume(program: DrivingProgram) -> None:
    program.send(signal.SIGTSTP)
    threading.Timer(_WATCHED / 3.0, program.send, [signal.SIGCONT]).start()


_SIGNALS: Final = signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP, signal.SIGUSR1
ENDINGS: Final[tuple[Ending, ...]] = (
    *(Ending(number.name, methodcaller("send", number)) for number in _SIGNALS),
    Ending("SIGTSTP, then SIGCONT", _suspend_and_resume),
    Ending("terminal closed", DrivingProgram.close_terminal, on_terminal=True),
    Ending("reader of the output ended", DrivingProgram.close_output),
    Ending("disk full", _fill_disk),
    Ending("own program: SIGTERM", lambda program: program.send(signal.SIGTERM), own_program=True),
    Ending("own program: a thread fails", lambda program: program.write_line("fail"), own_program=True),
)


def ending_result(ending: Ending, plant: str, watched: float = _WATCHED) -> EndingResult:
    """Start the program, wait until its robot moves, let it end, and watch the robot for some seconds."""
    scenario = load_scenario("corridor")
    with TemporaryDirectory(prefix="hopslam-") as folder, emulated_devices(scenario, plant=plant) as emulator:
        out = Path(folder) / "run"
        with emulator, _program(ending, emulator, out) as program:
            _await_drive(emulator, program)
            began = time.monotonic()
            before = emulator.truth[1]
            ending.action(program)
            to_command, to_stand = _watch(emulator, began, watched)
            driven = before.distance(emulator.truth[1])
            exit_code, recorded = program.wait(), (out / "metrics.json").exists()
            return EndingResult(ending.name, to_command, to_stand, driven, exit_code, recorded)


def _program(ending: Ending, emulator: Emulator, out: Path) -> DrivingProgram:
    settings = emulator.port_settings
    if ending.own_program:
        return DrivingProgram(settings, OWN_PROGRAM, ending.on_terminal)
    options = [word for setting in (*settings, f"route.speed={FORWARD.linear}") for word in ("--set", setting)]
    words = ["run", "corridor", "--backend", "hardware", "--yes", "--out", str(out), *options]
    return DrivingProgram(words, on_terminal=ending.on_terminal)


def _await_drive(emulator: Emulator, program: DrivingProgram) -> None:
    def drain() -> None:
        program.drain()
        time.sleep(0.01)

    if seconds_until(lambda: emulator.p3dx.motors.setpoint.linear >= 0.99 * FORWARD.linear, _START, drain) is None:
        raise RobotError(f"the program does not drive within {_START:g} s; is the machine busy?")


def _watch(emulator: Emulator, began: float, watched: float) -> tuple[float | None, float | None]:
    """Return the seconds until a stop command had arrived, and until the robot had come to rest for good."""
    to_command, moved, last = None, began, emulator.truth
    while time.monotonic() < began + watched:
        time.sleep(0.005)
        if to_command is None and emulator.p3dx.motors.linear.target == 0.0:
            to_command = time.monotonic() - began
        now = emulator.truth
        if now[0] - last[0] >= 0.02:
            if last[1].distance(now[1]) > _STANDING * (now[0] - last[0]):
                moved = now[0]
            last = now
    return to_command, (moved - began if moved < began + watched - 0.1 else None)
