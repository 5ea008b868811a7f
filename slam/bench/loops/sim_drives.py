"""Drives in the simulator with or without loop closing, scored against the true poses."""

from contextlib import closing
from dataclasses import dataclass, field
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from slam.bench.loops.both_ways import local_poses
from slam.bench.loops.loop_errors import LoopCounts, count_loops
from slam.bench.sim_runs import CASTER, HOUR
from slam.console.terminal import Terminal
from slam.graph.graph_size import GraphSize
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import Ending, run_loop
from slam.run.scoring.pose_errors import InterpolatedPoses, rmse
from slam.run.scoring.seen_walls import SeenWalls
from slam.run.scoring.wall_score import WallScore, score_walls
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario


class Drive(NamedTuple):
    """Result of a drive; errors in metres without alignment."""

    ending: Ending
    scans: int
    odometry_ate: float
    ate: float
    """Error of the poses as estimated at their scans."""
    final_ate: float
    """Error of the poses after the end; equal to ``ate`` if no loop is closed."""
    worst: float
    """Largest error of the poses as estimated at their scans."""
    final_worst: float
    """Largest error of the poses after the end."""
    walls: WallScore
    """Score of the map at the end of the drive, after loop closing if that is on."""
    times: FloatArray
    """Processor time of every update of the front end, seconds, (N,)."""
    finish_time: float
    """Wall time from the last scan to the closed map, seconds."""
    sizes: tuple[GraphSize, ...]
    """Size of the graph at every scan; empty without loop closing."""
    loops: LoopCounts | None
    """Counts of the loops; None without loop closing."""


class _MeasuredSlam(LineSlam):
    """Method with the processor time of every update and the size of its graph after it."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario.slam, scenario.lidar.mount.pose, scenario.robot.start.pose, scenario.seed)
        self.times: list[float] = []
        self.sizes: list[GraphSize] = []

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        began = process_time()
        estimate = super().update(scan, odometry)
        self.times.append(process_time() - began)
        if self.loops is not None:
            self.sizes.append(self.loops.size)
        return estimate


@dataclass
class _Recorder:
    """Watcher that keeps poses only."""

    estimates: list[Estimate] = field(default_factory=list)
    truth: list[Pose2D] = field(default_factory=list)
    wheels: list[Pose2D] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        observation, estimate = step.observation, step.estimate
        assert observation.T_map_base is not None
        self.estimates.append(Estimate(estimate.stamp, estimate.T_map_base, T_map_local=estimate.T_map_local))
        self.truth.append(observation.T_map_base)
        self.wheels.append(observation.odometry.T_odom_base)


def drive(name: str, seed: int, settings: tuple[str, ...], hour: bool = False) -> Drive:
    """Drive the scenario with this seed; with ``hour``, drive around its route for one simulated hour."""
    scenario = load_scenario(name, [CASTER, *settings, f"seed={seed}"])
    if hour:
        laps = scenario.route.model_copy(update={"waypoints": 100 * scenario.route.waypoints})
        scenario = scenario.model_copy(update={"route": laps, "duration": HOUR})
    warm_up(Terminal(quiet=True), scenario.slam)
    experiment, slam, recorder = scenario_experiment(scenario), _MeasuredSlam(scenario), _Recorder()
    seen = SeenWalls(experiment.outlines, slam.T_base_laser)
    with closing(experiment.env):
        ending = run_loop(
            experiment.env, slam, experiment.pilot, [recorder, seen], scenario.seed, duration=experiment.duration
        )
    began = perf_counter()
    closed = slam.finish()
    finish_time = perf_counter() - began
    live = stack_poses(estimate.T_map_base for estimate in recorder.estimates)
    final = live if closed is None else closed.trajectory(local_poses(recorder.estimates))
    lines = slam.lines.ends if closed is None else closed.map.ends
    start = recorder.truth[0] @ recorder.wheels[0].inverse()
    wheels = stack_poses(start @ pose for pose in recorder.wheels)
    off, final_off, wheels_off = (_distances(poses, stack_poses(recorder.truth)) for poses in (live, final, wheels))
    return Drive(
        ending, len(live), rmse(wheels_off), rmse(off), rmse(final_off), float(off.max()), float(final_off.max()),
        score_walls(seen.walls, seen.seen, lines), np.array(slam.times), finish_time, tuple(slam.sizes),
        None if closed is None else count_loops(closed, _at_every_scan(recorder.truth)),
    )  # fmt: skip


def _at_every_scan(poses: list[Pose2D]) -> InterpolatedPoses:
    return InterpolatedPoses(stack_poses(poses), np.ones(len(poses), np.bool_))


def _distances(poses: FloatArray, truth: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*(poses - truth)[:, :2].T))
