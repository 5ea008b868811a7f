"""A whole run: set up, driven through the loop, recorded, measured and drawn."""

import json
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from math import inf
from pathlib import Path
from signal import SIGINT
from time import perf_counter
from typing import Any

from slam.console.terminal import Terminal
from slam.errors import BatteryEmpty, HopslamError, InputError, RobotError, StorageError
from slam.files.atomic_files import write_atomic
from slam.files.logs import Loss
from slam.files.maps.file import write_map
from slam.line_slam import LineSlam
from slam.lines.learnt_noise import named_noise
from slam.pose import FloatArray, Pose2D
from slam.run.closing_loops import ClosedLoops, LoopCloser
from slam.run.estimator import DeadReckoning, Estimator, map_made_by, noise_learnt_by
from slam.run.loop import Ending, run_loop
from slam.run.pilots import Pilot
from slam.run.results.metrics import measure, noise_metrics
from slam.run.results.recorder import Recorder
from slam.run.results.run_folder import make_run_folder
from slam.run.results.run_log import KnownMap, RunLog
from slam.run.results.step_messages import StepMessages
from slam.run.robot_env import RobotEnv
from slam.run.scoring.seen_walls import SeenWalls
from slam.run.scoring.wall_score import score_walls, wall_metrics
from slam.run.step import Watcher
from slam.run.topics.topic_session import TopicSession
from slam.run.viewer.live_run import RunViewer
from slam.run.viewer.scene import Scene, planned_route, plots
from slam.run.viewer.viewers import Viewers
from slam.run.warm_up import warming_up
from slam.run.watchers import Interruption, RunProgress
from slam.scenario.file import dump_scenario
from slam.scenario.schema import Scenario


@dataclass(frozen=True, slots=True)
class Outcome:
    """Folder, ending and metrics of a run."""

    folder: Path
    ending: Ending
    metrics: dict[str, Any]
    error: HopslamError | None = None
    """Error of a run that failed."""
    signal: int = SIGINT
    """Number of the signal that interrupted it, if one did."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """A run that is set up and ready to go."""

    scenario: Scenario
    env: RobotEnv
    slam: Estimator
    pilot: Pilot
    seed: int
    outlines: Sequence[FloatArray] = ()
    """Outlines of the world that the lidar could see, for the picture."""
    notes: dict[str, Any] = field(default_factory=dict)
    """Additional entries of ``metrics.json``."""
    loss: Loss | None = None
    """Scans of the recorded log that could not be used."""
    T_map_odom: Pose2D | None = None
    """Start of dead reckoning; None for the robot's first estimate."""
    duration: float = inf
    """Seconds after which the robot gives no more scans, as the scenario says; infinite if it sets no such limit."""
    measures: Callable[[Path], dict[str, Any]] = measure
    """Computes the metrics of a run folder."""
    topics: TopicSession | None = None
    """Buses on which the run is published."""
    patience: float | None = None
    """Seconds to wait for a robot that fell silent; None for the scenario's setting."""

    def run(
        self,
        out: Path | None = None,
        viewers: Viewers | None = None,
        console: Terminal | None = None,
        pictures: bool = True,
    ) -> Outcome:
        """Run to the end, to Ctrl-C, or to a failure of the robot or of the user's own code.

        In every case the folder has the results so far. Raises InputError for files that cannot be written, before the
        run, and StorageError during it.
        """
        console = console or Terminal(quiet=True)
        self.env.prepare(self.seed)
        with nullcontext() if isinstance(self.slam, DeadReckoning) else self._warming_up(console):
            viewers = viewers or Viewers()
            viewers.start()
            folder = make_run_folder(self.scenario.name, out)
            try:
                return self._run_in(folder, viewers, console, pictures)
            except OSError as error:
                raise StorageError(f"{folder}: {error.strerror}; what was written until then is kept") from error

    def _warming_up(self, console: Terminal) -> AbstractContextManager[None]:
        """Compile the hot loops before the run; those of loop closing during it, unless the run is in real time."""
        real_time = "backend" in self.notes or self.topics is not None
        return warming_up(console, self.scenario.slam, search=not isinstance(self.slam, LineSlam), wait=real_time)

    def _run_in(self, folder: Path, viewers: Viewers, console: Terminal, pictures: bool) -> Outcome:
        write_atomic(folder / "config.yaml", dump_scenario(self.scenario))
        began, date = perf_counter(), datetime.now().astimezone().isoformat(timespec="seconds")
        seen, closer = SeenWalls(self.outlines, self.slam.T_base_laser), LoopCloser(self.slam)
        with Interruption() as interruption:
            ending, error, closed = self._drive(folder, viewers, console, seen, closer, interruption)
            wall_time = perf_counter() - began - (closed.seconds if closed else 0.0)
            metrics = self._measure(folder, ending, wall_time, seen, closed) | {"began": date}
            if closer.back_end_lost:
                metrics["back_end_lost"] = closer.back_end_lost
            if error is not None:
                metrics["error"] = str(error)
            write_atomic(folder / "metrics.json", json.dumps(metrics, indent=2) + "\n")
            if metrics["scans"] and pictures:
                self._draw(folder, console, closed)
        if interruption.signal is not None:
            return Outcome(folder, "interrupted", metrics, error, interruption.signal)
        return Outcome(folder, ending, metrics, error)

    def _draw(self, folder: Path, console: Terminal, closed: ClosedLoops | None) -> None:
        from slam.run.pictures.error_curves import draw_errors  # imported here, as matplotlib loads slowly
        from slam.run.pictures.map_picture import draw_map

        points, lines = (closed.run.map, closed.run.map) if closed else (self.slam.points, self.slam.lines)
        with console.waiting("drawing"), suppress(KeyboardInterrupt):
            draw_map(folder, points.points, lines.ends, self.outlines)
            draw_errors(folder)

    def _drive(
        self, folder: Path, viewers: Viewers, console: Terminal, seen: SeenWalls, closer: LoopCloser,
        interruption: Interruption,
    ) -> tuple[Ending, HopslamError | None, ClosedLoops | None]:  # fmt: skip
        """Run the loop, close its loops at the end, and show and write them."""
        messages = StepMessages()
        with ExitStack() as shown:
            viewer = published = None
            if (broadcast := viewers.open(self.scene, folder)) is not None:
                viewer = RunViewer(shown.enter_context(broadcast), self.scene)
            if self.topics is not None:
                published = shown.enter_context(self.topics.watcher(self.slam, self.scenario, messages))
            watchers: list[Watcher] = [seen, closer, *(shows for shows in (viewer, published) if shows)]
            ending, error = self._recorded_loop(folder, console, messages, watchers, interruption)
            closed = closer.close_loops(console)
            if viewer is not None:
                if closed is not None:
                    viewer.show_closed(closed.graph, closed.trajectory, closed.run.map)
                if closer.back_end_lost:
                    viewer.warn(closer.back_end_lost)
                viewer.end(ending, error)
            if closed is not None:
                closed.write(folder)
            elif closer.steps and (made := map_made_by(self.slam)) is not None:
                write_map(folder / "map.json", made)
            if published is not None:
                with suppress(KeyboardInterrupt):
                    published.show_end(folder)
        return ending, error, closed

    def _recorded_loop(
        self,
        folder: Path,
        console: Terminal,
        messages: StepMessages,
        watchers: Sequence[Watcher],
        interruption: Interruption,
    ) -> tuple[Ending, HopslamError | None]:
        """Run the loop with all its watchers, whose files are closed in any case."""
        T_map_odom, T_base_laser = self.T_map_odom or self.slam.T_map_base, self.slam.T_base_laser
        with ExitStack() as stack:
            recorder = stack.enter_context(Recorder(folder, T_map_odom, T_base_laser))
            log = stack.enter_context(RunLog(folder, T_base_laser, KnownMap.of(self.notes), messages))
            progress = stack.enter_context(RunProgress(console, self.scenario.name))
            return self._loop([recorder, log, *watchers, progress, interruption], interruption)

    def _loop(self, watchers: Sequence[Watcher], interruption: Interruption) -> tuple[Ending, HopslamError | None]:
        """Run the loop; in any case the robot is stopped at once."""
        try:
            patience = self.scenario.hardware.patience if self.patience is None else self.patience
            ending = run_loop(
                self.env, self.slam, self.pilot, watchers, self.seed, patience, self.duration, interruption.asked
            )
            return ending, None
        except KeyboardInterrupt:
            return "interrupted", None
        except BatteryEmpty as error:
            return "battery empty", error
        except (RobotError, InputError) as error:  # InputError: of the user's own extractor or matcher
            return ("failed", error) if interruption.signal is None else ("interrupted", None)
        finally:
            self.env.close()

    @property
    def scene(self) -> Scene:
        """Viewer's scene before the first scan."""
        odom = self.T_map_odom or self.slam.T_map_base
        deskew, outlines = self.scenario.slam.deskew, tuple(self.outlines)
        curves = plots(battery=self.notes.get("backend") == "hardware")
        route = planned_route(self.scenario)
        return Scene(self.slam.T_base_laser, odom, self.slam, deskew, outlines, route, plots=curves)

    def _measure(
        self, folder: Path, ending: Ending, wall_time: float, seen: SeenWalls, closed: ClosedLoops | None
    ) -> dict[str, Any]:
        metrics = self.measures(folder) | self.notes | (closed.metrics if closed else {})
        if (noise := noise_learnt_by(self.slam)) is not None and metrics["scans"]:
            metrics |= noise_metrics(noise, named_noise(self.scenario.slam.lines))
        if seen.scans.any() and not isinstance(self.slam, DeadReckoning):
            lines = closed.run.map if closed else self.slam.lines
            metrics |= wall_metrics(score_walls(seen.walls, seen.seen, lines.ends))
        metrics["ending"] = ending
        metrics["real_time_factor"] = round(metrics.get("duration_s", 0.0) / wall_time, 3)
        return metrics | {"seed": self.seed, "version": version("hopslam")}
