"""Runs of the method in the simulator, where the truth is known."""

import shlex
from contextlib import closing
from dataclasses import dataclass, field
from time import process_time
from typing import Final

import numpy as np

from slam.console.terminal import Terminal
from slam.line_slam import Estimate, LineSlam
from slam.mapping.surfel_map import SurfelMap
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, relative_poses, stack_poses, wrap_angles
from slam.run.experiment_setup import scenario_experiment
from slam.run.loop import Ending, run_loop
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

CASTER: Final = "lidar.caster=exact"
"""Setting of all runs, not the default of ``hopslam run``: each ray caster rounds differently."""
HOUR: Final = 3600.0
"""Seconds of the long run."""


class _TimedSlam(LineSlam):
    """Method with the processor time of every update."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario.slam, scenario.lidar.mount.pose, scenario.robot.start.pose, scenario.seed)
        self.times: list[float] = []
        self.nbytes: list[int] = []

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        began = process_time()
        estimate = super().update(scan, odometry)
        self.times.append(process_time() - began)
        assert isinstance(self.points, SurfelMap)  # paper mode has no covariance, and is not measured here
        self.nbytes.append(self.points.nbytes)
        return estimate


@dataclass
class _Recorder:
    """Watcher that keeps numbers only: an hour of scans would not fit into memory."""

    poses: list[Pose2D] = field(default_factory=list)
    truth: list[Pose2D] = field(default_factory=list)
    wheels: list[Pose2D] = field(default_factory=list)
    covariances: list[FloatArray] = field(default_factory=list)
    unconstrained: list[bool] = field(default_factory=list)
    lost: int = 0
    odometry_only: int = 0
    map_points: list[int] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        observation, estimate = step.observation, step.estimate
        assert observation.T_map_base is not None
        assert estimate.covariance is not None
        self.poses.append(estimate.T_map_base)
        self.truth.append(observation.T_map_base)
        self.wheels.append(observation.odometry.T_odom_base)
        self.covariances.append(estimate.covariance)
        self.unconstrained.append(estimate.unconstrained is not None and len(estimate.unconstrained) > 0)
        self.lost += estimate.lost
        self.odometry_only += estimate.match.odometry_only
        self.map_points.append(estimate.map_points)


@dataclass(frozen=True, slots=True, eq=False)
class SimRun:
    """Result of a run; poses are rows x, y, theta, (N, 3), of ``T_map_base``."""

    ending: Ending
    poses: FloatArray
    truth: FloatArray
    odometry: FloatArray
    """Poses by the wheels alone, from the true start."""
    covariances: FloatArray
    """Covariances of the estimates, (N, 3, 3)."""
    unconstrained: FloatArray
    """True for each scan that did not constrain the pose in every direction, (N,)."""
    lost: int
    """Number of scans in which the robot was lost."""
    odometry_only: int
    """Number of scans that were matched but rejected."""
    times: FloatArray
    """Seconds of processor time of every update, (N,)."""
    map_points: FloatArray
    """Number of surfels after every scan, (N,)."""
    map_bytes: FloatArray
    """Memory of the map after every scan, bytes, (N,)."""

    @property
    def offsets(self) -> FloatArray:
        """Estimate minus truth, (N, 3)."""
        return _offsets(self.poses, self.truth)

    @property
    def odometry_offsets(self) -> FloatArray:
        """Odometry minus truth, (N, 3)."""
        return _offsets(self.odometry, self.truth)

    @property
    def true_heading_offsets(self) -> FloatArray:
        """Offsets (N, 3) of an odometry with the true heading: the error of its distances alone."""
        steps = relative_poses(self.odometry[:-1], self.odometry[1:])
        c, s = np.cos(self.truth[:-1, 2]), np.sin(self.truth[:-1, 2])
        moves = np.column_stack([c * steps[:, 0] - s * steps[:, 1], s * steps[:, 0] + c * steps[:, 1]])
        places = self.truth[0, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(moves, axis=0)])
        return np.column_stack([places - self.truth[:, :2], np.zeros(len(places))])

    @property
    def normalised_errors(self) -> FloatArray:
        """Squared Mahalanobis distances of all estimates but the first from the truth, (N - 1,).

        They are chi-square with three degrees of freedom if the covariance is correct.
        """
        offsets = self.offsets[1:]
        weighed = np.linalg.solve(self.covariances[1:], offsets[..., None])[..., 0]
        return np.asarray(np.sum(offsets * weighed, axis=1))


def run_scenario(
    name: str, seed: int, settings: tuple[str, ...], hour: bool = False, allow_modules: tuple[str, ...] = ()
) -> SimRun:
    """Drive the shipped scenario with this seed; with ``hour``, drive around its route for one hour."""
    scenario = load_scenario(name, [CASTER, *settings, f"seed={seed}"], allow_modules)
    if hour:
        laps = scenario.route.model_copy(update={"waypoints": 100 * scenario.route.waypoints})
        scenario = scenario.model_copy(update={"route": laps, "duration": HOUR})
    warm_up(Terminal(quiet=True), scenario.slam)
    experiment, slam, recorder = scenario_experiment(scenario), _TimedSlam(scenario), _Recorder()
    with closing(experiment.env):
        ending = run_loop(experiment.env, slam, experiment.pilot, [recorder], scenario.seed)
    start = recorder.truth[0] @ recorder.wheels[0].inverse()
    return SimRun(
        ending=ending,
        poses=stack_poses(recorder.poses),
        truth=stack_poses(recorder.truth),
        odometry=stack_poses([start @ wheels for wheels in recorder.wheels]),
        covariances=np.array(recorder.covariances),
        unconstrained=np.array(recorder.unconstrained, np.float64),
        lost=recorder.lost,
        odometry_only=recorder.odometry_only,
        times=np.array(slam.times),
        map_points=np.array(recorder.map_points, np.float64),
        map_bytes=np.array(slam.nbytes, np.float64),
    )


def repeating_command(name: str, seed: int, settings: tuple[str, ...] = (), allow_modules: tuple[str, ...] = ()) -> str:
    """Return the shell command that repeats ``run_scenario`` with these arguments, bit for bit."""
    words = [word for text in (CASTER, *settings) for word in ("--set", text)]
    words += [word for module in allow_modules for word in ("--allow-module", module)]
    return shlex.join(["hopslam", "run", name, "--seed", str(seed), *words])


def _offsets(poses: FloatArray, truth: FloatArray) -> FloatArray:
    offsets = poses - truth
    offsets[:, 2] = wrap_angles(offsets[:, 2])
    return offsets
