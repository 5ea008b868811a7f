"""Localisation trials: a run makes a map, then robots are set down anywhere in it, and moved without being told."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from slam.config import SlamConfig
from slam.line_localizer import LineLocalizer
from slam.line_slam import Estimate, LineSlam
from slam.mapping.surfel_map import SurfelMap
from slam.matching.surfel_mapper import SurfelMapper
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.backends import make_robot
from slam.run.pilot import WaypointPilot
from slam.run.results.localization_metrics import RIGHT
from slam.run.wanderer import Wanderer
from slam.scenario.schema import Scenario
from slam.scenario.solids import clearance, obstacle_footprints
from slam.scenario.values import Place

FREE: Final = 0.4
"""Metres around a start that must be free."""
MAPPED: Final = 1.0
"""A start is no farther than this from the way that the mapping robot took, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class MappedWorld:
    """A world, the map that a run made of it, and how wrong that is."""

    scenario: Scenario
    config: SlamConfig
    map: SurfelMap
    truth: FloatArray
    """``T_map_base`` of the run that mapped, (N, 3) ..."""
    estimate: FloatArray
    """... and as it was estimated."""

    def in_map(self, T_map_base: Pose2D) -> Pose2D:
        """Where a true pose lies in the map, which is as wrong there as the run was when it came nearest."""
        k = int(np.argmin(np.hypot(*(self.truth[:, :2] - T_map_base.translation).T)))
        return Pose2D(*self.estimate[k].tolist()) @ Pose2D(*self.truth[k].tolist()).between(T_map_base)


@dataclass(frozen=True, slots=True)
class Stay:
    """What came of one time that a robot was set down, or moved."""

    right_after: float | None
    """Seconds to the first scan since which it was sure and right, to the end; None where it was not at the end."""
    wrong: int
    """Scans in which it was sure, and wrong."""
    errors: tuple[float, ...]
    """Metres from the true pose, of the scans since then ..."""
    errors_in_map: tuple[float, ...]
    """... and from where that lies in the map."""
    times: tuple[float, ...]
    """Seconds of wall time of every update."""


def map_world(scenario: Scenario, config: SlamConfig) -> MappedWorld:
    """Drive the scenario's route once, mapping."""
    start = scenario.robot.start.pose
    slam, pilot = LineSlam(config, scenario.lidar.mount.pose, start), WaypointPilot(scenario.route, start)
    truth, estimates = [], []
    with make_robot("sim", scenario) as robot:
        while (observation := robot.observe()) is not None:
            estimate = slam.update(observation.scan, observation.odometry)
            assert observation.T_map_base is not None
            truth.append(_row(observation.T_map_base))
            estimates.append(_row(estimate.T_map_base))
            command = pilot.command(estimate.T_map_base)
            if command is None:
                break
            robot.drive(command)
    assert isinstance(slam.mapper, SurfelMapper)
    return MappedWorld(scenario, config, slam.mapper.map, np.array(truth), np.array(estimates))


def starts(world: MappedWorld, random: np.random.Generator) -> Iterator[Pose2D]:
    """Random free poses of the mapped part of the world."""
    solids, way = obstacle_footprints(world.scenario.world.prisms()), world.truth[:, :2]
    low, high = way.min(axis=0) - MAPPED, way.max(axis=0) + MAPPED
    while True:
        place = random.uniform(low, high)
        theta = float(random.uniform(-np.pi, np.pi))
        if np.hypot(*(way - place).T).min() < MAPPED and clearance(place[np.newaxis], solids)[0] > FREE:
            yield Pose2D(float(place[0]), float(place[1]), theta)


def trial(world: MappedWorld, places: tuple[Pose2D, Pose2D], seconds: float, seed: int) -> tuple[Stay, Stay]:
    """A robot that is set down at the first place and wanders, and is then moved to the second, as its wheels do not
    notice; each for so many simulated seconds."""
    localizer = LineLocalizer(world.config, world.scenario.lidar.mount.pose, world.map)
    first, T_odom_base = _stay(world, localizer, places[0], Pose2D(), seconds, seed)
    second, _ = _stay(world, localizer, places[1], T_odom_base, seconds, seed)
    return first, second


def _stay(
    world: MappedWorld, localizer: LineLocalizer, place: Pose2D, T_odom_base: Pose2D, seconds: float, seed: int
) -> tuple[Stay, Pose2D]:
    """One stay, and the odometry at its end."""
    robot = world.scenario.robot.model_copy(update={"start": Place(x=place.x, y=place.y, theta=place.theta)})
    scenario = world.scenario.model_copy(update={"robot": robot, "duration": seconds})
    pilot, begun, seen = Wanderer(), T_odom_base, []
    with make_robot("sim", scenario, seed=seed) as wandering:
        while (observation := wandering.observe()) is not None:
            T_odom_base = begun @ observation.odometry.T_odom_base
            odometry = replace(observation.odometry, T_odom_base=T_odom_base)
            seen.append((observation, localizer.update(observation.scan, odometry)))
            wandering.drive(pilot.command(seen[-1][1].T_map_base, observation.scan))
    return _judged(world, seen), T_odom_base


def _judged(world: MappedWorld, seen: list[tuple[Observation, Estimate]]) -> Stay:
    sure = [not estimate.lost for _, estimate in seen]
    truth = [observation.T_map_base or Pose2D() for observation, _ in seen]
    poses = [estimate.T_map_base for _, estimate in seen]
    near = [a.distance(b) < RIGHT[0] and abs(a.between(b).theta) < RIGHT[1] for a, b in zip(truth, poses, strict=True)]
    right = [a and b for a, b in zip(sure, near, strict=True)]
    since = len(right)
    while since > 0 and right[since - 1]:
        since -= 1
    return Stay(
        right_after=seen[since][1].stamp - seen[0][1].stamp if since < len(right) else None,
        wrong=sum(a and not b for a, b in zip(sure, near, strict=True)),
        errors=tuple(a.distance(b) for a, b in zip(truth[since:], poses[since:], strict=True)),
        errors_in_map=tuple(world.in_map(a).distance(b) for a, b in zip(truth[since:], poses[since:], strict=True)),
        times=tuple(estimate.total_time for _, estimate in seen),
    )


def _row(pose: Pose2D) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.theta
