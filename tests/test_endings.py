"""When a program ends, is suspended or loses its terminal, the driver stops the robot."""

import os
import signal
import threading
import time

import pytest

from hardware.bench.driving_program import OWN_PROGRAM, DrivingProgram
from hardware.bench.emulated_robot import emulated_devices
from hardware.bench.endings import ENDINGS, Ending, ending_result
from hardware.emulator.emulator import Emulator
from hardware.operator_consent import OperatorConsent
from hardware.process_watch import StopCallbacks, process_watch
from slam.errors import OutputLost, RobotError
from slam.scenario.file import load_scenario

BY_NAME = {ending.name: ending for ending in ENDINGS}
IN_TIME = 0.9
"""Seconds for which a robot is watched, and within which it must stop: less than half of its watchdog's.
``hopslam bench hardware endings`` prints the measured times."""


def own(name: str) -> Ending:
    """The same ending, of a user's own program, which starts faster than hopslam."""
    ending = BY_NAME[name]
    return Ending(name, ending.action, own_program=True, on_terminal=ending.on_terminal)


@pytest.mark.parametrize(
    ("ending", "exit_codes"),
    [
        (own("SIGINT"), {130, -signal.SIGINT}),  # Python ends itself by SIGINT after a KeyboardInterrupt
        (own("SIGQUIT"), {131}),
        (own("SIGUSR1"), {138}),
        (BY_NAME["own program: SIGTERM"], {143}),
        (BY_NAME["own program: a thread fails"], {1}),
        (own("terminal closed"), {129, 1}),  # by SIGHUP, or by OutputLost if that comes first
        (own("reader of the output ended"), {1}),
        (own("SIGTSTP, then SIGCONT"), {1}),
    ],
    ids=lambda value: value.name if isinstance(value, Ending) else "",
)
def test_the_robot_stops_when_its_program_ends(ending: Ending, exit_codes: set[int]) -> None:
    result = ending_result(ending, "plan", IN_TIME)
    assert result.to_command is not None
    assert result.to_stand is not None
    assert result.exit_code in exit_codes


@pytest.mark.parametrize(("name", "exit_code", "recorded"), [("SIGHUP", 129, True), ("disk full", 3, False)])
def test_the_robot_stops_when_its_run_ends(name: str, exit_code: int, recorded: bool) -> None:
    result = ending_result(BY_NAME[name], "plan", IN_TIME)
    assert result.to_stand is not None
    assert (result.exit_code, result.recorded) == (exit_code, recorded)


def test_a_robot_stops_when_the_output_pipe_closes() -> None:
    with (
        emulated_devices(load_scenario("corridor"), plant="plan") as emulator,
        emulator,
        DrivingProgram(emulator.port_settings, OWN_PROGRAM) as program,
    ):
        start = emulator.truth[1]
        program.close_output()
        assert program.wait() == 1
        assert emulator.truth[1] == start


def wait_for_motion(emulator: Emulator, moving: bool) -> None:
    until = time.monotonic() + 30.0
    while emulator.p3dx.motors.moving != moving:
        assert time.monotonic() < until
        time.sleep(0.01)


def test_a_closed_terminal_does_not_end_a_nohup_program() -> None:
    ignoring = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    with emulated_devices(load_scenario("corridor"), plant="plan") as emulator, emulator:
        with DrivingProgram(emulator.port_settings, ignoring + OWN_PROGRAM) as program:
            wait_for_motion(emulator, True)
            program.send(signal.SIGHUP)
            time.sleep(0.5)
            assert emulator.p3dx.motors.linear.target > 0.0
        wait_for_motion(emulator, False)


class Notes:
    """Keeps the calls of a watch: each end with its reason, and each suspension."""

    def __init__(self) -> None:
        self.ends: list[tuple[str, RobotError | None]] = []
        self.suspended: list[str] = []
        self.ended = threading.Event()
        self.stop = StopCallbacks(self.end, self.suspended.append)

    def end(self, reason: str, error: RobotError | None) -> None:
        self.ends.append((reason, error))
        self.ended.set()


def test_signal_handlers_are_restored() -> None:
    seen: list[int] = []
    before = {number: signal.getsignal(number) for number in signal.valid_signals()}
    signal.signal(signal.SIGTERM, lambda number, _: seen.append(number))
    try:
        notes = Notes()
        with process_watch(notes.stop):
            signal.raise_signal(signal.SIGTERM)
            assert notes.ended.wait(20.0)
            with pytest.raises(SystemExit) as left:
                signal.raise_signal(signal.SIGHUP)
        assert left.value.code == 128 + signal.SIGHUP
        assert notes.ends[0] == ("the program got SIGTERM", None)
        assert seen == [signal.SIGTERM]
    finally:
        signal.signal(signal.SIGTERM, before[signal.SIGTERM])
    assert {number: signal.getsignal(number) for number in signal.valid_signals()} == before


def test_all_robots_stop_and_the_last_restores_the_signals() -> None:
    before = signal.getsignal(signal.SIGHUP)
    first, second = Notes(), Notes()
    with process_watch(second.stop):
        with process_watch(first.stop):
            pass
        assert signal.getsignal(signal.SIGHUP) != before
        with pytest.raises(SystemExit):
            signal.raise_signal(signal.SIGHUP)
        assert second.ended.wait(20.0)
    assert first.ends == []
    assert signal.getsignal(signal.SIGHUP) == before


def test_a_robot_closed_in_a_thread_leaves_the_signals() -> None:
    before = signal.getsignal(signal.SIGHUP)
    watch, notes = process_watch(Notes().stop), Notes()
    watch.__enter__()
    closing = threading.Thread(target=watch.__exit__, args=(None, None, None))
    closing.start()
    closing.join()
    with process_watch(notes.stop):
        with pytest.raises(SystemExit):
            signal.raise_signal(signal.SIGHUP)
        assert notes.ended.wait(20.0)
    assert signal.getsignal(signal.SIGHUP) == before
    assert signal.set_wakeup_fd(-1) == -1


def test_a_forked_child_has_its_own_signals() -> None:
    notes = Notes()
    ready, child_end = os.pipe()
    with process_watch(notes.stop):
        child = os.fork()
        if not child:
            try:
                os.write(child_end, b"!")
                time.sleep(60.0)
            finally:
                os._exit(0)
        assert os.read(ready, 1) == b"!"
        os.kill(child, signal.SIGTERM)
        os.waitpid(child, 0)
    os.close(ready)
    os.close(child_end)
    assert notes.ends == []


def test_an_event_loop_still_gets_signals() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    handler = signal.signal(signal.SIGINT, lambda *_: None)
    previous = signal.set_wakeup_fd(writer)
    try:
        notes = Notes()
        with process_watch(notes.stop):
            signal.raise_signal(signal.SIGINT)
            assert os.read(reader, 1) == bytes([signal.SIGINT])
        assert signal.set_wakeup_fd(writer) == writer
    finally:
        signal.set_wakeup_fd(previous)
        signal.signal(signal.SIGINT, handler)
        os.close(reader)
        os.close(writer)


def test_a_later_event_loop_does_not_keep_the_signals() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    handler = signal.signal(signal.SIGINT, lambda *_: None)
    try:
        notes = Notes()
        with process_watch(notes.stop) as keep:
            signal.set_wakeup_fd(writer)
            keep()
            signal.raise_signal(signal.SIGINT)
            assert notes.ended.wait(20.0)
            assert os.read(reader, 1) == bytes([signal.SIGINT])
    finally:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, handler)
        os.close(reader)
        os.close(writer)


def test_revoked_consent_is_asked_for_even_with_yes() -> None:
    consent = OperatorConsent(True)
    consent.withdraw()
    assert consent.given
    consent.revoke()
    assert not consent.given
    with pytest.raises(RobotError, match="the program was suspended: start it again"):
        consent.ask(lambda: False)


def test_lost_output_has_the_exit_code_of_a_broken_pipe() -> None:
    assert OutputLost("gone").exit_code == 128 + signal.SIGPIPE
