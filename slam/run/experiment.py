"""A whole run: set up, driven through the loop, recorded, measured and drawn."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from math import inf
from pathlib import Path
from signal import SIGINT
from time import perf_counter
from typing import Any

import numpy as np

from slam.console.terminal import Terminal
from slam.errors import HopslamError, InputError, RobotError, ScenarioError, StorageError
from slam.files.logs import BagTopics, read_log
from slam.files.maps.file import write_map
from slam.files.whole_files import write_whole
from slam.line_slam import LineSlam
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.run.backends import make_robot
from slam.run.estimator import DeadReckoning, Estimator, make_estimator, map_made_by
from slam.run.interruption import Interruption
from slam.run.loop import Ending, run_loop
from slam.run.pilot import Pilot, ReplayPilot, WaypointPilot
from slam.run.results.keep import Keep
from slam.run.results.metrics import measure
from slam.run.results.progress import RunProgress
from slam.run.results.recorder import Recorder
from slam.run.results.run_folder import make_run_folder
from slam.run.results.run_log import RunLog
from slam.run.robot_env import RobotEnv
from slam.run.step import Watcher
from slam.run.viewer.run_viewer import RunViewer
from slam.run.viewer.scene import Scene
from slam.run.viewer.viewers import Viewers
from slam.run.warm_up import warm_up
from slam.scenario.file import dump_scenario
from slam.scenario.schema import Scenario


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run left behind."""

    folder: Path
    ending: Ending
    metrics: dict[str, Any]
    error: HopslamError | None = None
    """Why it failed, where it did."""
    signal: int = SIGINT
    """Number of the signal that interrupted it, where one did."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """All that one run needs, ready to go."""

    scenario: Scenario
    env: RobotEnv
    slam: Estimator
    pilot: Pilot
    seed: int
    outlines: Sequence[FloatArray] = ()
    """What of the world the lidar could see, for the picture."""
    notes: dict[str, Any] = field(default_factory=dict)
    """More for ``metrics.json``."""
    T_map_odom: Pose2D | None = None
    """Where dead reckoning begins; None: at the robot's first estimate."""
    duration: float = inf
    """The scenario's, seconds, where the robot keeps to it."""
    measures: Callable[[Path], dict[str, Any]] = measure
    """The metrics of the folder."""

    def run(
        self,
        out: Path | None = None,
        viewers: Viewers | None = None,
        console: Terminal | None = None,
        keep: Keep = Keep(),  # noqa: B008  # it is frozen
    ) -> Outcome:
        """Run to the end, to Ctrl-C, or to the failure of the robot or of the user's own code.

        What was done is in the folder in every case. Raises InputError for files that cannot be written, before
        anything is done, and StorageError on the way.
        """
        console = console or Terminal(quiet=True)
        self.env.prepare(self.seed)
        if not isinstance(self.slam, DeadReckoning):
            warm_up(console, self.scenario.slam, search=not isinstance(self.slam, LineSlam))
        folder = make_run_folder(self.scenario.name, out)
        try:
            return self._run_in(folder, viewers or Viewers(), console, keep)
        except OSError as error:
            raise StorageError(f"{folder}: {error.strerror}; what was written until then is kept") from error

    def _run_in(self, folder: Path, viewers: Viewers, console: Terminal, keep: Keep) -> Outcome:
        write_whole(folder / "config.yaml", dump_scenario(self.scenario))
        began, date = perf_counter(), datetime.now().astimezone().isoformat(timespec="seconds")
        with Interruption() as interruption:
            ending, error = self._drive(folder, viewers, console, interruption)
            metrics = self._measure(folder, ending, perf_counter() - began) | {"began": date}
            if error is not None:
                metrics["error"] = str(error)
            if (made := map_made_by(self.slam)) is not None and metrics["scans"]:
                write_map(folder / "map.json", made)
            write_whole(folder / "metrics.json", json.dumps(metrics, indent=2) + "\n")
            if metrics["scans"] and keep.pictures:
                self._draw(folder, console)
        if interruption.signal is not None:
            return Outcome(folder, "interrupted", metrics, error, interruption.signal)
        return Outcome(folder, ending, metrics, error)

    def _draw(self, folder: Path, console: Terminal) -> None:
        from slam.run.results.error_picture import draw_errors  # late: matplotlib takes long to load
        from slam.run.results.map_picture import draw_map

        with console.waiting("drawing"), suppress(KeyboardInterrupt):
            draw_map(folder, self.slam.points.points, self.slam.lines.ends, self.outlines)
            draw_errors(folder)

    def _drive(
        self, folder: Path, viewers: Viewers, console: Terminal, interruption: Interruption
    ) -> tuple[Ending, HopslamError | None]:
        """The loop, with its watchers, whose files are closed whatever ends it."""
        with ExitStack() as stack:
            recorder = Recorder(folder, self.T_map_odom or self.slam.T_map_base, self.slam.T_base_laser)
            stack.callback(recorder.close)
            log = RunLog(folder, self.slam.T_base_laser)
            stack.callback(log.close)
            watchers: list[Watcher] = [recorder, log]
            viewer = None
            if (broadcast := viewers.open(self.setting, folder)) is not None:
                viewer = RunViewer(stack.enter_context(broadcast), self.setting)
                watchers.append(viewer)
            watchers += [stack.enter_context(RunProgress(console, self.scenario.name)), interruption]
            ending, error = self._loop(watchers, interruption)
            if viewer is not None:
                viewer.end(ending, error)
            return ending, error

    def _loop(self, watchers: Sequence[Watcher], interruption: Interruption) -> tuple[Ending, HopslamError | None]:
        """Whatever ends it, the robot is stopped at once."""
        try:
            patience = self.scenario.hardware.patience
            return run_loop(self.env, self.slam, self.pilot, watchers, self.seed, patience, self.duration), None
        except KeyboardInterrupt:
            return "interrupted", None
        except (RobotError, InputError) as error:  # InputError: of an extractor or matcher of the user's own
            return ("failed", error) if interruption.signal is None else ("interrupted", None)
        finally:
            self.env.close()

    @property
    def setting(self) -> Scene:
        """What a viewer is told before the first scan."""
        start, waypoints = self.scenario.robot.start.pose, self.scenario.route.waypoints
        route = np.array([(start.x, start.y), *waypoints]) if waypoints else None
        odom = self.T_map_odom or self.slam.T_map_base
        deskew, outlines = self.scenario.slam.deskew, tuple(self.outlines)
        return Scene(self.slam.T_base_laser, odom, self.slam, deskew, outlines, route)

    def _measure(self, folder: Path, ending: Ending, wall_time: float) -> dict[str, Any]:
        metrics = self.measures(folder) | self.notes
        metrics["ending"] = ending
        metrics["real_time_factor"] = round(metrics.get("duration_s", 0.0) / wall_time, 3)
        return metrics | {"seed": self.seed, "version": version("hopslam")}


def scenario_experiment(scenario: Scenario, backend: str = "sim", **options: bool) -> Experiment:
    """A robot of this back end, driving the scenario's route on the pose that the method estimates.

    ``options`` are the back end's own. Only the simulated robot needs the scenario's world.
    """
    if backend == "sim" and not scenario.world.prisms():
        raise ScenarioError(f"{scenario.name}: nothing to see: the world is empty; a log is run by hopslam replay LOG")
    start, lidar = scenario.robot.start.pose, scenario.lidar
    return Experiment(
        scenario=scenario,
        env=RobotEnv(
            lambda seed: make_robot(backend, scenario, seed=seed, **options),
            lidar.description.lidar,
            Twist2D(scenario.robot.limits.linear, scenario.robot.limits.angular),
        ),
        slam=make_estimator(scenario.slam, lidar.mount.pose, start, scenario.seed),
        pilot=WaypointPilot(scenario.route, start),
        seed=scenario.seed,
        outlines=scenario.world.outlines(lidar.height),
        duration=scenario.duration,
        notes={} if backend == "sim" else {"backend": backend, "dry_run": options.get("dry_run", False)},
    )


def replay_experiment(path: Path, scenario: Scenario, topics: BagTopics | None = None) -> Experiment:
    """A recorded log, through the method as the scenario sets it; its world and robot are not used.

    The robot begins where the log says it is in the map, or at the origin; without odometry in the log, none is used.
    """
    log = read_log(path, topics)
    name = re.sub(r"[^A-Za-z0-9._ -]", "-", path.resolve().name.lstrip(".")).split(".")[0] or "log"
    slam = (
        scenario.slam
        if log.has_odometry
        else scenario.slam.model_copy(update={"odometry": False, "update_distance": 0.0})
    )
    scenario = Scenario(name=name, description=f"replay of {path.name}", slam=slam, seed=scenario.seed)
    return Experiment(
        scenario=scenario,
        env=RobotEnv(lambda seed: make_robot("replay", log), log.lidar, Twist2D(10.0, 10.0)),
        slam=make_estimator(scenario.slam, log.T_base_laser, log.start, scenario.seed),
        pilot=ReplayPilot(len(log)),
        seed=scenario.seed,
        notes={"log": str(path), "log_report": log.report},
    )
