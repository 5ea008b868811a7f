"""``hopslam bench ros``: lost scans, their ages in an rclpy callback, and the loop's time for publishing."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any, Final

import numpy as np

from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.run.experiment import Experiment
from slam.run.experiment_setup import on_topics, scenario_experiment
from slam.run.loop import run_loop
from slam.run.pilots import Wanderer
from slam.run.results.step_messages import StepMessages
from slam.run.step import Step
from slam.run.topics.slam_topics import SlamTopics
from slam.run.topics.topic_session import TopicSession
from slam.run.warm_up import warm_up
from slam.scenario.schema import Scenario
from slam.topics.ros_bus import open_ros_bus

_CLIENT: Final = Path(__file__).with_name("ros_client.py")
_LONGER: Final = 30.0
"""Seconds for which a client waits after the run."""
_TARGETS: Final = "targets: none lost, median age 5 ms, 0.3 ms a scan; encoding the scan for the log is not counted"


class _EnoughScans(Exception):
    """Ends the run after the requested number of scans."""


@dataclass
class _Stopwatch:
    """Measures the watcher that publishes, without the encoding for the log; ends the run after ``scans`` scans."""

    watcher: SlamTopics
    messages: StepMessages
    scans: int
    stamps: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    cpu: float = 0.0

    def on_step(self, step: Step) -> None:
        """Time one step."""
        self.messages.of(step)
        began, began_cpu = perf_counter(), thread_time()
        self.watcher.on_step(step)
        self.seconds.append(perf_counter() - began)
        self.cpu += thread_time() - began_cpu
        self.stamps.append(step.observation.scan.stamp)
        if len(self.stamps) == self.scans:
            raise _EnoughScans


def ros_table(scenario: Scenario, pythons: Sequence[Path], seconds: float, console: Terminal) -> ResultTable:
    """Drive a robot in the scenario for this time, in real time, with a listening client of each Python.

    InputError if a Python has no rclpy.
    """
    warm_up(console, scenario.slam)
    wandering = scenario.model_copy(update={"duration": seconds})
    with ExitStack() as open_until_end, console.waiting(f"driving for {seconds:g} s"):
        clients = {path: open_until_end.enter_context(_listener(path, seconds + _LONGER)) for path in pythons}
        watch = _drive(wandering, open_until_end)
        heard = {path: json.loads(client.communicate()[0].splitlines()[-1]) for path, client in clients.items()}
    cost = [f"{1e3 * np.median(watch.seconds):.3f}", f"{1e3 * watch.cpu / len(watch.seconds):.3f}"]
    rows = [
        [path.absolute().parents[1].name, *_figures(watch.stamps, received), *cost] for path, received in heard.items()
    ]
    columns = (
        "client",
        "scans",
        "lost",
        "age ms\nmedian",
        "age ms\n99 %",
        "age ms\nworst",
        "publish\nms",
        "publish\nCPU ms",
    )
    return ResultTable(f"Topics of ROS 2: {scenario.name}, {seconds:g} s at 10 Hz, reliable", columns, rows, _TARGETS)


def _drive(scenario: Scenario, stack: ExitStack) -> _Stopwatch:
    session = stack.enter_context(TopicSession([open_ros_bus()]))
    experiment: Experiment = on_topics(scenario_experiment(scenario), session)
    messages = StepMessages()
    watcher = stack.enter_context(session.watcher(experiment.slam, scenario, messages))
    watch = _Stopwatch(watcher, messages, ceil(scenario.duration / scenario.lidar.description.lidar.scan_time))
    with closing(experiment.env), suppress(_EnoughScans):
        run_loop(experiment.env, experiment.slam, Wanderer(), [watch], experiment.seed)
    return watch


def _figures(sent: Sequence[float], received: dict[str, Any]) -> Iterator[str]:
    """Yield the cells of a client: scans sent since it was found, scans lost, and their ages."""
    heard = np.array(received["stamps"])
    since = [stamp for stamp in sent if stamp > heard.min(initial=np.inf) - 1e-6]
    yield f"{len(since)} of {len(sent)}"
    yield f"{sum(np.abs(heard - stamp).min() > 1e-6 for stamp in since)}"
    ages = 1e3 * np.array(received["ages"] or [np.nan])
    yield from (f"{age:.2f}" for age in (np.median(ages), np.percentile(ages, 99), ages.max()))


@contextmanager
def _listener(python: Path, seconds: float) -> Iterator[subprocess.Popen[str]]:
    """A listening client; InputError if there is no rclpy."""
    command = [str(python), str(_CLIENT), "listen", f"{seconds:g}"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True) as client:
        try:
            if client.stdout is None or client.stdout.readline() != "ready\n":
                raise InputError(f"{python}: no rclpy with sensor_msgs and nav_msgs; make test-ros installs one")
            yield client
        finally:
            client.kill()
