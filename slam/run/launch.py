"""Functions that set up and execute a run and return its results; used by the CLI and by Python programs."""

from pathlib import Path
from typing import Any, Literal

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.logs import BagTopics
from slam.pose import Pose2D
from slam.run.carry_out import carry_out
from slam.run.experiment_setup import (
    continue_mapping,
    following_experiment,
    localize_in_map,
    scenario_experiment,
)
from slam.run.log_or_scenario import Settings, is_recorded, path_of, recorded_experiment, refuse, with_slam
from slam.run.ros_robot.robot import TopicRobot
from slam.run.run import Run
from slam.run.topics.topic_choice import TopicChoice
from slam.run.viewer.viewers import Viewers
from slam.scenario.file import load_scenario, load_template
from slam.scenario.settings import with_seed


def run(
    scenario: str | Path = "corridor",
    *,
    seed: int | None = None,
    settings: Settings = (),
    slam: SlamConfig | None = None,
    out: str | Path | None = None,
    saved_map: str | Path | None = None,
    start: Literal["given", "search"] = "given",
    backend: str = "sim",
    allow_modules: Settings = (),
    rerun: Settings = (),
    ros: bool = False,
    foxglove: bool | int | str = False,
    pace: float | None = None,
    pictures: bool = True,
    check: bool = True,
    yes: bool = False,
    dry_run: bool = False,
    record_wire: str | Path | None = None,
    viewers: Viewers | None = None,
    console: Terminal | None = None,
) -> Run:
    """Drive a robot through a scenario, and map it, as ``hopslam run`` does.

    ``scenario`` is the name of a shipped one or the path of a YAML file, ``settings`` are those of ``--set``, and
    ``slam`` replaces its section slam. With ``saved_map``, the ``map.json`` of another run, mapping continues in that
    map from the scenario's start, or, with ``start="search"``, from the pose that the robot finds. Results are in the
    folder ``out``, by default ``runs/<name>-<time>``. With ``yes`` the real robot moves without asking first, and with
    ``dry_run`` not at all; ``record_wire`` is a file for all bytes of its ports.

    InputError for wrong arguments, before the run. A run that fails raises its error, and an interrupted one
    KeyboardInterrupt, after everything is written; with ``check=False`` the run is returned instead. ``rerun`` is the
    option ``--rerun``; ``ros``, ``foxglove``, which may be a port or ``HOST:PORT``, and ``pace`` are the options with
    these names. Commands pass their own ``viewers`` and ``console``.
    """
    console = console or Terminal(quiet=True)
    template = load_template(scenario, with_seed(settings, seed), allow_modules)
    drawn = with_slam(template.draw(), slam)
    console.warn(*template.warnings(drawn))
    if ros and backend == "ros":
        raise InputError(
            "--ros publishes topics of the robot, and the robot of --backend ros has its own; leave out --ros"
        )
    experiment = scenario_experiment(drawn, backend, **_robot_options(backend, yes, dry_run, record_wire))
    if saved_map is not None:
        experiment = continue_mapping(experiment, path_of("saved_map", saved_map), start)
    return carry_out(experiment, out, rerun, TopicChoice(ros, foxglove, pace), pictures, check, False, viewers, console)


def replay(
    log: str | Path,
    *,
    scenario: str | Path | None = None,
    settings: Settings = (),
    slam: SlamConfig | None = None,
    out: str | Path | None = None,
    saved_map: str | Path | None = None,
    start: Literal["search", "saved"] = "search",
    scan_topic: str | None = None,
    odom_topic: str | None = None,
    lenient: bool = False,
    allow_modules: Settings = (),
    rerun: Settings = (),
    ros: bool = False,
    foxglove: bool | int | str = False,
    pace: float | None = None,
    pictures: bool = True,
    check: bool = True,
    viewers: Viewers | None = None,
    console: Terminal | None = None,
) -> Run:
    """Map a recorded log, bag or run folder, as ``hopslam replay`` does.

    The settings of SLAM come from ``scenario``, by default from the recorded run's own scenario, or from ``replay`` for
    a log or a bag. With ``saved_map`` mapping continues in that map, from the pose that the robot finds or, with
    ``start="saved"``, from the end of the other run. ``scan_topic`` and ``odom_topic`` choose topics of a bag.
    ScansLost if most scans of the log cannot be used, unless ``lenient``. All other arguments and errors are those of
    ``run``.
    """
    console = console or Terminal(quiet=True)
    topics = BagTopics(scan_topic, odom_topic)
    experiment = recorded_experiment(path_of("log", log), scenario, settings, slam, allow_modules, topics, console)
    if saved_map is not None:
        experiment = continue_mapping(experiment, path_of("saved_map", saved_map), start)
    return carry_out(
        experiment, out, rerun, TopicChoice(ros, foxglove, pace), pictures, check, lenient, viewers, console
    )


def localize(
    source: str | Path,
    saved_map: str | Path,
    *,
    scenario: str | Path | None = None,
    seed: int | None = None,
    settings: Settings = (),
    slam: SlamConfig | None = None,
    out: str | Path | None = None,
    scan_topic: str | None = None,
    odom_topic: str | None = None,
    lenient: bool = False,
    allow_modules: Settings = (),
    rerun: Settings = (),
    ros: bool = False,
    foxglove: bool | int | str = False,
    pace: float | None = None,
    pictures: bool = True,
    check: bool = True,
    viewers: Viewers | None = None,
    console: Terminal | None = None,
) -> Run:
    """Find the robot of a scenario, or of a recorded log, in a saved map and track it, as ``hopslam localize`` does.

    The map does not change. The arguments are those of ``run`` for a scenario and those of ``replay`` for a log.
    """
    console = console or Terminal(quiet=True)
    if is_recorded(source):
        refuse("a recorded log, in which nothing is random", source, seed=seed)
        topics = BagTopics(scan_topic, odom_topic)
        experiment = recorded_experiment(
            path_of("source", source), scenario, settings, slam, allow_modules, topics, console
        )
    else:
        refuse("a scenario, and no log", source, scenario=scenario, scan_topic=scan_topic, odom_topic=odom_topic)
        drawn = load_scenario(source, with_seed(settings, seed), allow_modules)
        experiment = scenario_experiment(with_slam(drawn, slam))
    localizing = localize_in_map(experiment, path_of("saved_map", saved_map))
    return carry_out(
        localizing, out, rerun, TopicChoice(ros, foxglove, pace), pictures, check, lenient, viewers, console
    )


def follow(
    scenario: str | Path = "replay",
    *,
    settings: Settings = (),
    slam: SlamConfig | None = None,
    mount: tuple[float, float, float] | None = None,
    out: str | Path | None = None,
    saved_map: str | Path | None = None,
    start: Literal["search", "saved"] = "search",
    keep_map: bool = False,
    allow_modules: Settings = (),
    rerun: Settings = (),
    foxglove: bool | int | str = False,
    pictures: bool = True,
    check: bool = True,
    viewers: Viewers | None = None,
    console: Terminal | None = None,
) -> Run:
    """Map the surroundings of a robot of ROS 2 that others drive, as ``hopslam ros slam`` does, until Ctrl-C.

    The topics and the settings of the method are those of the scenario. ``mount`` is the pose x, y, theta of the lidar
    if the robot's transforms do not contain it. With ``saved_map`` mapping continues in that map; with ``keep_map`` the
    robot is localised in it and the map does not change. All other arguments are those of ``replay``.
    """
    console = console or Terminal(quiet=True)
    drawn = with_slam(load_scenario(scenario, settings, allow_modules), slam)
    if saved_map is None and keep_map:
        raise InputError("--localize needs the map of another run; add --map FILE")
    with TopicRobot(drawn, follows=True, mount=Pose2D(*(mount or ()))) as robot:
        with console.waiting(f"waiting for {drawn.ros.scan_topic}"):
            robot.meet()
        experiment = following_experiment(drawn, robot)
        if saved_map is not None:
            path = path_of("saved_map", saved_map)
            experiment = localize_in_map(experiment, path) if keep_map else continue_mapping(experiment, path, start)
        choice = TopicChoice(ros=True, foxglove=foxglove, follows=robot)
        return carry_out(experiment, out, rerun, choice, pictures, check, False, viewers, console)


def _robot_options(backend: str, yes: bool, dry_run: bool, record_wire: str | Path | None) -> dict[str, Any]:
    """Return the options of the back end; InputError for unknown ones."""
    if backend == "hardware":
        return {"yes": yes, "dry_run": dry_run, "record_wire": record_wire and Path(record_wire)}
    if backend == "replay":
        raise InputError("--backend replay has no log to play; run: hopslam replay LOG")
    if yes or dry_run or record_wire:
        raise InputError("--yes, --dry-run and --record-wire are for the real robot; add --backend hardware")
    return {}
