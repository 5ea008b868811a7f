"""Cost of showing a run: the time and the bytes of a scan."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep, thread_time
from typing import Final, NamedTuple

from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import run_loop
from slam.run.step import Step
from slam.run.viewer.broadcast import Broadcast
from slam.run.viewer.live_run import RunViewer
from slam.run.viewer.rerun_program import data_address, is_listening, serve_page
from slam.run.warm_up import warm_up
from slam.scenario.schema import Scenario

_PORT: Final = 19090
_ROWS: Final = 5
_TARGETS: Final = "targets: 0.5 ms and 7 kB a scan, with --rerun FILE"


class _EnoughScans(Exception):
    """Ends the run after the requested number of scans."""


class ViewerCost(NamedTuple):
    """Cost of one way to show a run."""

    name: str
    scans: int
    seconds: Sequence[float]
    """Time that the loop spent in the viewer, for each scan."""
    close: float
    """Seconds to write the rest at the end."""
    cpu: float
    """Processor seconds of the loop's thread for all of that."""
    size: int = 0
    """Size of the file, bytes."""

    def row(self) -> list[str]:
        """Return the cells of the table."""
        total = 1e3 * (sum(self.seconds) + self.close) / self.scans
        worst = 1e3 * max(self.seconds[1:])
        size = f"{self.size / self.scans / 1e3:.2f}" if self.size else "-"
        return [
            self.name, f"{self.scans}", f"{1e3 * self.cpu / self.scans:.3f}", f"{total:.3f}", f"{worst:.1f}",
            f"{1e3 * self.seconds[0]:.0f}", size,
        ]  # fmt: skip


def viewer_table(scenario: Scenario, scans: int, console: Terminal) -> ResultTable:
    """Drive the scenario again for each row, with the same seed; live rows run at 10 Hz for ``scans`` scans."""
    warm_up(console, scenario.slam)
    with TemporaryDirectory() as folder, console.progress() as bar:
        costs = _costs(scenario, scans, Path(folder) / "run.rrd")
        rows = [cost.row() for cost in bar.track(costs, total=_ROWS, description="driving")]
    columns = ("shown in", "scans", "CPU ms\na scan", "ms\na scan", "worst\nms", "first\nms", "kB\na scan")
    return ResultTable(f"What the viewer costs the loop: {scenario.name}", columns, rows, _TARGETS)


def _costs(scenario: Scenario, scans: int, path: Path) -> Iterator[ViewerCost]:
    address = data_address(_PORT + 1)
    yield _measured("a file, whole run, no pause", scenario, None, 0.0, [path], [])
    yield _measured("a file, at 10 Hz", scenario, scans, 0.1, [path], [])
    yield _measured("no viewer at the address, 10 Hz", scenario, scans, 0.1, [], [address])
    with _server() as server:
        yield _measured("a viewer, 10 Hz", scenario, scans, 0.1, [], [address])
        yield _measured("a viewer killed half way, 10 Hz", scenario, scans, 0.1, [], [address], server)


@contextmanager
def _server() -> Iterator[subprocess.Popen[bytes]]:
    server = serve_page(_PORT)
    try:
        yield server
    finally:
        server.kill()
        server.wait()
        while is_listening(data_address(_PORT + 1)):
            sleep(0.1)


def _measured(
    name: str,
    scenario: Scenario,
    scans: int | None,
    period: float,
    files: list[Path],
    urls: list[str],
    viewer_to_kill: subprocess.Popen[bytes] | None = None,
) -> ViewerCost:
    experiment = scenario_experiment(scenario)
    with Broadcast(files, urls, experiment.scene, lambda text: None) as broadcast:
        watcher = _Stopwatch(RunViewer(broadcast, experiment.scene), scans, period, viewer_to_kill)
        with closing(experiment.env), suppress(_EnoughScans):
            run_loop(experiment.env, experiment.slam, experiment.pilot, [watcher], experiment.seed)
        began, began_cpu = perf_counter(), thread_time()
    cpu = watcher.cpu + thread_time() - began_cpu
    size = files[0].stat().st_size if files else 0
    return ViewerCost(name, len(watcher.seconds), watcher.seconds, perf_counter() - began, cpu, size)


@dataclass
class _Stopwatch:
    """Times another watcher at every scan; waits for the next scan, and kills a viewer and ends the run if asked to."""

    watcher: RunViewer
    scans: int | None
    period: float
    viewer_to_kill: subprocess.Popen[bytes] | None
    seconds: list[float] = field(default_factory=list)
    cpu: float = 0.0
    next_scan: float = field(default_factory=perf_counter)

    def on_step(self, step: Step) -> None:
        """Time the watcher, then wait for the next scan."""
        began, began_cpu = perf_counter(), thread_time()
        self.watcher.on_step(step)
        self.seconds.append(perf_counter() - began)
        self.cpu += thread_time() - began_cpu
        if self.scans is not None and step.index + 1 >= self.scans:
            raise _EnoughScans
        if self.viewer_to_kill is not None and self.scans is not None and step.index == self.scans // 2:
            self.viewer_to_kill.kill()
        self.next_scan = max(self.next_scan + self.period, perf_counter())
        sleep(max(0.0, self.next_scan - perf_counter()) if self.period else 0.0)
