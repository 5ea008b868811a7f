"""Start-up times: of the help, and until the first scan of a run."""

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from shlex import quote
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import Final

from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.errors import InputError

_HOPSLAM: Final = (sys.executable, "-c", "from slam.cli.main import main; main()")
"""Command of the console script."""
_TIMEOUT: Final = 120.0
_TARGETS: Final = {"hopslam --help": 0.4, "first scan": 3.0}
"""Seconds, with warm caches."""


def start_up_table(scenario: str, repeats: int, console: Terminal, allow_modules: Sequence[str] = ()) -> ResultTable:
    """Time each start in a new process, after one that warms the caches and is not counted."""
    allow_options = [word for name in allow_modules for word in ("--allow-module", name)]
    measures: dict[str, Callable[[], float]] = {
        "hopslam --help": _help,
        "first scan": lambda: _first_scan(scenario, allow_options),
    }
    rows = []
    for name, measure in measures.items():
        with console.progress(transient=True, still=True) as bar:
            _, *seconds = [measure() for _ in bar.track(range(repeats + 1), description=name)]
        seconds.sort()
        rows.append([name, *(f"{value:.2f}" for value in (seconds[0], seconds[repeats // 2], _TARGETS[name]))])
    columns = ("", "least s", "median s", "target s")
    notes = "wall time, from the start of the process"
    return ResultTable(f"Start-up: {scenario}, {repeats} times", columns, rows, notes)


def _help() -> float:
    began = perf_counter()
    subprocess.run([*_HOPSLAM, "--help"], check=True, capture_output=True)
    return perf_counter() - began


def _first_scan(scenario: str, allow_options: Sequence[str]) -> float:
    """Return the seconds until a run has written its first pose; then end the run."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        poses = out / "trajectory.tum"
        began = perf_counter()
        command = [*_HOPSLAM, "run", scenario, "--out", str(out), *allow_options]
        run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            while not (poses.is_file() and poses.stat().st_size):
                if run.poll() is not None or perf_counter() - began > _TIMEOUT:
                    raise InputError(f"{scenario}: no first scan; try: hopslam run {quote(scenario)}")
                sleep(0.002)
            return perf_counter() - began
        finally:
            run.kill()
            run.wait()
