"""Hot loops are compiled once, before they are needed, and partly in a process beside the run."""

import subprocess
import sys
from collections.abc import Iterator

import pytest

from slam.compiled import is_cold
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.graph.wall_landmarks import wall_spans
from slam.mapping.free_space import carve
from slam.mapping.surfel_updates import put
from slam.mapping.wall_evidence import weigh_walls
from slam.matching.coarse_search import correlative_search
from slam.matching.least_squares import solve
from slam.run import loops_warm_up, warm_up

Process = subprocess.Popen[bytes]
SHARED = (solve, correlative_search, put, carve, weigh_walls)


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Process]]:
    """Processes that were started to compile; each lasts until it is killed, as on a slow machine."""
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


def test_both_processes_compile_the_same_code() -> None:
    loops_warm_up.match_scans(SlamConfig())
    first = {function: list(function.signatures) for function in SHARED}
    warm_up.warm_up(Terminal(quiet=True), SlamConfig())
    assert all(first.values())
    assert {function: list(function.signatures) for function in SHARED} == first
    assert not is_cold(wall_spans)
