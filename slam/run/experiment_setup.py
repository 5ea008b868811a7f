"""Experiments set up: on a robot or a recorded log, from scratch or in a saved map."""

import re
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any, Literal

from slam.config import SlamConfig
from slam.errors import InputError, ScenarioError
from slam.files.graphs.file import read_graph
from slam.files.graphs.key_scans import read_known_graph
from slam.files.logs import BagTopics, read_log
from slam.files.maps.file import read_map
from slam.graph.known_graph import KnownGraph
from slam.graph.loop_closing import STEPPED, Timing
from slam.line_localizer import LineLocalizer, LocalizeThenMap
from slam.line_slam import LineSlam
from slam.odometry import Twist2D
from slam.run.backends import make_robot
from slam.run.estimator import make_estimator
from slam.run.experiment import Experiment
from slam.run.pilots import LocalizeThenDrive, Passenger, ReplayPilot, Wanderer, WaypointPilot
from slam.run.results.metrics import measure_localization
from slam.run.results.traces import Traces
from slam.run.robot_env import RobotEnv
from slam.run.ros_robot.robot import TopicRobot
from slam.run.topics.paced_robot import PacedRobot
from slam.run.topics.stepped_robot import SteppedRobot
from slam.run.topics.topic_session import TopicSession
from slam.run.topics.velocity_commands import CommandedPilot
from slam.saved_slam import relocate
from slam.scenario.file import read_scenario
from slam.scenario.schema import Scenario


def scenario_experiment(scenario: Scenario, backend: str = "sim", **options: Any) -> Experiment:
    """Set up a robot of this back end to drive the scenario's route on the estimated pose.

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
        slam=make_estimator(scenario.slam, lidar.mount.pose, start, scenario.seed, Timing(real_time=backend != "sim")),
        pilot=WaypointPilot(scenario.route, start),
        seed=scenario.seed,
        outlines=scenario.world.outlines(lidar.height),
        duration=scenario.duration,
        notes={} if backend == "sim" else {"backend": backend, "dry_run": options.get("dry_run", False)},
    )


def replay_experiment(path: Path, scenario: Scenario, topics: BagTopics | None = None) -> Experiment:
    """Set up a recorded log to run through the method of the scenario; its world and robot are not used.

    The robot begins at the log's start in the map, or at the origin; if the log has no odometry, none is used.
    """
    log = read_log(path, topics)
    name = re.sub(r"[^A-Za-z0-9._ -]", "-", path.resolve().name.lstrip(".")).split(".")[0] or "log"
    slam = scenario.slam if log.has_odometry else scenario.slam.without_odometry()
    scenario = Scenario(name=name, description=f"replay of {path.name}", slam=slam, seed=scenario.seed)
    return Experiment(
        scenario=scenario,
        env=RobotEnv(lambda seed: make_robot("replay", log), log.lidar, Twist2D(10.0, 10.0)),
        slam=make_estimator(scenario.slam, log.T_base_laser, log.start, scenario.seed, _timing_of(path, scenario.slam)),
        pilot=ReplayPilot(len(log)),
        seed=scenario.seed,
        notes={"log": str(path), "log_report": log.report, "log_lost_scans": log.lost},
        loss=log.loss,
    )


def following_experiment(scenario: Scenario, robot: TopicRobot) -> Experiment:
    """Set up the method of the scenario on a robot that others drive; it ends on request.

    The robot begins at the scenario's start pose; the scenario's world is not used.
    """
    start, slam, ros = scenario.robot.start.pose, scenario.slam, scenario.ros
    scenario = Scenario(
        name="ros_slam", description=f"scans of {ros.scan_topic}", slam=slam, ros=ros, seed=scenario.seed
    )
    return Experiment(
        scenario=scenario,
        env=RobotEnv(lambda seed: robot, robot.lidar.lidar, Twist2D(10.0, 10.0)),
        slam=make_estimator(slam, robot.T_base_laser, start, scenario.seed, Timing(real_time=True)),
        pilot=Passenger(),
        seed=scenario.seed,
        notes={"backend": "ros"},
        patience=inf,
    )


def _timing_of(path: Path, config: SlamConfig) -> Timing:
    """Return the rule for closures: at the scans where the run of this log applied them, if it had the same settings.

    A real robot does not wait for closures; by this rule a replay gives the same bits. STEPPED for any other log.
    """
    folder = path if path.is_dir() else path.parent
    if not (folder / "config.yaml").is_file() or read_scenario(folder / "config.yaml").slam != config:
        return STEPPED
    traces = Traces.read(folder)
    return STEPPED if traces is None or traces.closures is None else Timing(known=traces.closures)


def continue_mapping(experiment: Experiment, path: Path, start: Literal["given", "saved", "search"]) -> Experiment:
    """Let the experiment continue the map in this file.

    The robot starts at the experiment's start (``given``), at its last pose in the saved map (``saved``), or must find
    its pose first (``search``), for which a simulated robot wanders. InputError for a map that cannot be used.
    """
    config, mount, begun = experiment.scenario.slam, experiment.slam.T_base_laser, experiment.slam
    timing = begun.timing if isinstance(begun, LineSlam) else STEPPED
    saved = replace(read_map(path, config), graph=_graph_of(path, config))
    experiment = replace(experiment, notes=experiment.notes | {"map": str(path), "start": start})
    if start == "search":
        continuation = LocalizeThenMap(config, mount, saved, timing)
        return _searching(replace(experiment, slam=continuation), lambda: continuation.slam is not None)
    place = saved.T_map_base if start == "saved" else experiment.slam.T_map_base
    return replace(experiment, slam=relocate(config, mount, saved, place, timing))


def _graph_of(path: Path, config: SlamConfig) -> KnownGraph | None:
    """Return the graph of a map, from the files beside it; None without them, or if no loops are to be closed."""
    graph, keys = path.with_name("graph.json"), path.with_name("key_scans.npz")
    if config.loops == "never" or not (graph.is_file() and keys.is_file()):
        return None
    return read_known_graph(keys, read_graph(graph))


def localize_in_map(experiment: Experiment, path: Path) -> Experiment:
    """Let the experiment find its pose in the map of this file, which does not change.

    A simulated robot wanders until it is sure, and then drives its route, or continues to wander without one.
    InputError for a map that cannot be used.
    """
    config = experiment.scenario.slam
    saved = read_map(path, config)
    localizer = LineLocalizer(config, experiment.slam.T_base_laser, saved.mapper.map, noise=saved.noise)
    notes = experiment.notes | {"map": str(path)}
    localizing = replace(experiment, slam=localizer, notes=notes, measures=measure_localization)
    return _searching(localizing, lambda: localizer.sure)


def _searching(experiment: Experiment, known: Callable[[], bool]) -> Experiment:
    """Let a robot that can be driven wander while its pose is unknown."""
    if isinstance(experiment.pilot, Passenger):
        return experiment
    then = experiment.pilot if experiment.scenario.route.waypoints else Wanderer()
    start = experiment.scenario.robot.start.pose
    return replace(experiment, pilot=LocalizeThenDrive(known, then), T_map_odom=start)


def on_topics(experiment: Experiment, topics: TopicSession) -> Experiment:
    """Let the experiment be published and driven on topics.

    A simulated robot and a recorded log then run at the pace of the wall clock. A robot drives its route until the
    first command comes, and then follows commands; with pace 0 it stands until the next command. InputError for an
    impossible pace.
    """
    topics.hear_initial_pose(experiment.slam)
    experiment = replace(_paced(experiment, topics), topics=topics)
    if isinstance(experiment.pilot, Passenger):
        return experiment
    topics.hear_commands()
    return replace(experiment, pilot=CommandedPilot(topics.commands, experiment.pilot))


def _paced(experiment: Experiment, topics: TopicSession) -> Experiment:
    """Let the robot of the experiment run at the pace of the session; InputError if it cannot."""
    pace = topics.pace
    if "backend" in experiment.notes:
        if pace is not None:
            raise InputError(f"--pace {pace:g}: a robot that is not simulated goes at its own pace; leave it out")
        return experiment
    if pace == inf:
        return experiment
    if pace != 0.0:
        return replace(
            experiment, env=experiment.env.wrapped(lambda robot: PacedRobot(robot, pace or 1.0, topics.on_time))
        )
    if isinstance(experiment.pilot, Passenger):
        raise InputError("--pace 0: a recorded log hears no commands to wait for; give a number above 0, or inf")
    env = experiment.env.wrapped(lambda robot: SteppedRobot(robot, topics.commands))
    return replace(experiment, env=env, patience=inf)
