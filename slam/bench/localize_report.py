"""``hopslam bench localize``: a run makes a map, then robots are placed in it, and carried to another place."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.line_localizer import LineLocalizer
from slam.line_slam import Estimate, LineSlam
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.robot import Observation
from slam.run.backends import make_robot
from slam.run.closing_loops import LoopCloser
from slam.run.estimator import map_made_by
from slam.run.pilots import Wanderer, WaypointPilot
from slam.run.results.metrics import RIGHT
from slam.run.warm_up import warm_up
from slam.saved_slam import SavedSlam
from slam.scenario.schema import Scenario
from slam.scenario.solids import clearance, obstacle_footprints
from slam.scenario.values import Place

CLEARANCE: Final = 0.4
"""Metres around a start that are free."""
MAX_FROM_ROUTE: Final = 1.0
"""Largest distance of a start from the path of the mapping robot, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class MappedWorld:
    """World of a scenario, the map that a run made of it, and the errors of that run."""

    scenario: Scenario
    saved: SavedSlam
    """The map, with its loops closed, as ``map.json`` has it."""
    truth: FloatArray
    """True poses ``T_map_base`` of the mapping run, (N, 3)."""
    estimate: FloatArray
    """Poses of the mapping run in the map, (N, 3)."""

    @property
    def map(self) -> SurfelMap:
        """The surfels of the map."""
        return self.saved.mapper.map

    def in_map(self, T_map_base: Pose2D) -> Pose2D:
        """Return the pose in the map for a true pose: shifted by the error of the mapping run's pose nearest to it."""
        k = int(np.argmin(np.hypot(*(self.truth[:, :2] - T_map_base.translation).T)))
        return Pose2D(*self.estimate[k].tolist()) @ Pose2D(*self.truth[k].tolist()).between(T_map_base)


@dataclass(frozen=True, slots=True)
class TrialResult:
    """Result of placing a robot, or of moving it to a new place."""

    right_after: float | None
    """Seconds until it was sure and right for good; None if it was not sure and right in the last scan."""
    wrong: int
    """Number of scans in which it was sure, and wrong."""
    errors: tuple[float, ...]
    """Distances from the true pose in the scans from then on, metres."""
    errors_in_map: tuple[float, ...]
    """Distances in the same scans from the pose that ``in_map`` gives for the true pose, metres."""
    times: tuple[float, ...]
    """Seconds of wall time of every update."""


def localization_table(scenario: Scenario, trials: int, seconds: float, seed: int, console: Terminal) -> ResultTable:
    """Map the scenario's world, and place and move ``trials`` robots in it."""
    warm_up(console, scenario.slam, search=True)
    with console.waiting(f"mapping {scenario.name}"):
        world = map_world(scenario)
    places = draw_start_poses(world, np.random.default_rng(seed))
    with console.progress(transient=True) as bar:
        results = [
            trial(world, (next(places), next(places)), seconds, seed + k)
            for k in bar.track(range(trials), description=scenario.name)
        ]
    relocate, moved = zip(*results, strict=True)
    ate = np.sqrt(np.mean(np.sum((world.estimate - world.truth)[:, :2] ** 2, axis=1)))
    return ResultTable(
        f"Localisation in {scenario.name}, seed {scenario.seed}: {trials} trials of {seconds:g} s",
        ["", "right", "after, s", "95 %, s", "worst, s", "scans\nwrong", "in map,\nm", "true,\nm", "first,\nms",
         "scan,\nms"],
        [_table_row("set down", relocate), _table_row("moved", moved)],
        f"The map has {len(world.map)} surfels, from one run with an ATE of {ate:.3f} m. Each robot starts at a random "
        "pose, and is then carried to another one. Right: at the end it is sure of a pose within 0.3 m and 5 deg of "
        "the true one; after: median of the simulated time until it stays so. Wrong: scans in which it was sure of "
        "another pose. In map: rmse after that time against the place of the true pose in the map; true: against the "
        "true pose. First: wall time of the search in the whole map.",
    )  # fmt: skip


def map_world(scenario: Scenario) -> MappedWorld:
    """Drive the scenario's route once, map it, and close the loops."""
    start = scenario.robot.start.pose
    slam, pilot = LineSlam(scenario.slam, scenario.lidar.mount.pose, start), WaypointPilot(scenario.route, start)
    closer, truth, estimates = LoopCloser(slam), [], []
    with make_robot("sim", scenario) as robot:
        while (observation := robot.observe()) is not None:
            estimate = slam.update(observation.scan, observation.odometry)
            assert observation.T_map_base is not None
            truth.append(observation.T_map_base)
            estimates.append(estimate.T_map_base)
            closer.add(estimate)
            command = pilot.command(estimate.T_map_base)
            if command is None:
                break
            robot.drive(command)
    closed = closer.closed()
    saved = map_made_by(slam) if closed is None else closed.saved
    assert saved is not None
    poses = stack_poses(estimates) if closed is None else closed.trajectory
    return MappedWorld(scenario, saved, stack_poses(truth), poses)


def draw_start_poses(world: MappedWorld, random: np.random.Generator) -> Iterator[Pose2D]:
    """Draw free poses in the mapped part of the world."""
    solids, path = obstacle_footprints(world.scenario.world.prisms()), world.truth[:, :2]
    low, high = path.min(axis=0) - MAX_FROM_ROUTE, path.max(axis=0) + MAX_FROM_ROUTE
    while True:
        place = random.uniform(low, high)
        theta = float(random.uniform(-np.pi, np.pi))
        if np.hypot(*(path - place).T).min() < MAX_FROM_ROUTE and clearance(place[np.newaxis], solids)[0] > CLEARANCE:
            yield Pose2D(float(place[0]), float(place[1]), theta)


def trial(
    world: MappedWorld, places: tuple[Pose2D, Pose2D], seconds: float, seed: int
) -> tuple[TrialResult, TrialResult]:
    """Place a robot at the first pose, then move it to the second, which its wheels do not measure.

    It wanders at each for this number of simulated seconds.
    """
    mount = world.scenario.lidar.mount.pose
    localizer = LineLocalizer(world.scenario.slam, mount, world.map, noise=world.saved.noise)
    first, T_odom_base = _wander_at(world, localizer, places[0], Pose2D(), seconds, seed)
    second, _ = _wander_at(world, localizer, places[1], T_odom_base, seconds, seed)
    return first, second


def _wander_at(
    world: MappedWorld, localizer: LineLocalizer, place: Pose2D, T_odom_base: Pose2D, seconds: float, seed: int
) -> tuple[TrialResult, Pose2D]:
    """Let the robot wander at one place; return the result, and the odometry at the end."""
    robot = world.scenario.robot.model_copy(update={"start": Place(x=place.x, y=place.y, theta=place.theta)})
    scenario = world.scenario.model_copy(update={"robot": robot, "duration": seconds})
    pilot, begun, seen = Wanderer(), T_odom_base, []
    with make_robot("sim", scenario, seed=seed) as wandering:
        while (observation := wandering.observe()) is not None:
            T_odom_base = begun @ observation.odometry.T_odom_base
            odometry = replace(observation.odometry, T_odom_base=T_odom_base)
            seen.append((observation, localizer.update(observation.scan, odometry)))
            wandering.drive(pilot.command(seen[-1][1].T_map_base, observation.scan))
    return _evaluated(world, seen), T_odom_base


def _evaluated(world: MappedWorld, seen: list[tuple[Observation, Estimate]]) -> TrialResult:
    sure = [not estimate.lost for _, estimate in seen]
    truth = [observation.T_map_base or Pose2D() for observation, _ in seen]
    poses = [estimate.T_map_base for _, estimate in seen]
    near = [a.distance(b) < RIGHT[0] and abs(a.between(b).theta) < RIGHT[1] for a, b in zip(truth, poses, strict=True)]
    right = [a and b for a, b in zip(sure, near, strict=True)]
    since = len(right)
    while since > 0 and right[since - 1]:
        since -= 1
    return TrialResult(
        right_after=seen[since][1].stamp - seen[0][1].stamp if since < len(right) else None,
        wrong=sum(a and not b for a, b in zip(sure, near, strict=True)),
        errors=tuple(a.distance(b) for a, b in zip(truth[since:], poses[since:], strict=True)),
        errors_in_map=tuple(world.in_map(a).distance(b) for a, b in zip(truth[since:], poses[since:], strict=True)),
        times=tuple(estimate.total_time for _, estimate in seen),
    )


def _table_row(name: str, results: tuple[TrialResult, ...]) -> list[str]:
    after = [result.right_after for result in results if result.right_after is not None]
    times = np.array([result.times[0] for result in results])
    return [
        name,
        f"{len(after)} of {len(results)}",
        *(f"{np.percentile(after, share):.1f}" if after else "-" for share in (50, 95, 100)),
        str(sum(result.wrong for result in results)),
        _rmse([result.errors_in_map for result in results]),
        _rmse([result.errors for result in results]),
        f"{1e3 * np.median(times):.0f}",
        f"{1e3 * np.median(np.concatenate([result.times for result in results])):.2f}",
    ]


def _rmse(errors: list[tuple[float, ...]]) -> str:
    values = np.concatenate(errors)
    return f"{np.sqrt(np.mean(values**2)):.3f}" if len(values) else "-"
