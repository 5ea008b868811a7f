"""Hot loops are compiled once, before they are needed, and partly in a process beside the run."""

import subprocess
import sys
from collections.abc import Iterator

import pytest

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.graph.wall_landmarks import wall_spans
from slam.run import loops_warm_up, warm_up

Process = subprocess.Popen[bytes]
COUNTED = """
import sys
from numba.core.registry import CPUDispatcher
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.run.loops_warm_up import match_scans
from slam.run.warm_up import warm_up

match_scans(SlamConfig())
warm_up(Terminal(quiet=True), SlamConfig(), search=True)
ours = [module for name, module in sys.modules.items() if name.startswith("slam.")]
loops = {value for module in ours for value in vars(module).values() if isinstance(value, CPUDispatcher)}
assert sum(len(loop.signatures) == 1 for loop in loops) > 40
print(*(loop.__name__ for loop in loops if len(loop.signatures) > 1))
"""


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Process]]:
    """Processes that a test starts in place of compilers; each lasts until it gets a line of input or is killed."""
    started: list[Process] = []

    def start() -> Process:
        started.append(subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE))
        return started[-1]

    monkeypatch.setattr(loops_warm_up, "_started", start)
    monkeypatch.setattr(loops_warm_up, "is_cold", lambda function: function is wall_spans)
    yield started
    for process in started:
        process.communicate()


def test_a_run_begins_while_loop_closing_is_compiled(beside: list[Process]) -> None:
    with warm_up.warming_up(Terminal(quiet=True), SlamConfig()):
        (process,) = beside
        assert process.poll() is None
    assert process.returncode != 0


def test_a_run_in_real_time_waits_for_all_hot_loops(beside: list[Process]) -> None:
    with loops_warm_up.compiling_beside() as finish:
        (process,) = beside
        assert process.stdin is not None
        process.stdin.write(b"\n")
        process.stdin.flush()
        finish()
        assert process.poll() == 0


def test_nothing_is_compiled_beside_once_all_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loops_warm_up, "is_cold", lambda function: False)
    monkeypatch.setattr(loops_warm_up, "_started", lambda: pytest.fail("a process was started"))
    with loops_warm_up.compiling_beside() as finish:
        finish()


def test_no_hot_loop_is_compiled_for_two_types_of_arguments() -> None:
    run = subprocess.run([sys.executable, "-c", COUNTED], check=True, capture_output=True, text=True)
    assert run.stdout.split() == []
