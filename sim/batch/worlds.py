"""The scenarios of a batch, as arrays. Metres, seconds, radians, map frame."""

from collections.abc import Sequence
from itertools import pairwise
from math import hypot
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.crowd import Crowd, crowd_of
from sim.gait import LEG_HEIGHT
from sim.plan.footprint import RADIUS
from sim.records import model_of
from sim.wall_plan import WallPlan, wall_plan
from slam.env.config import EnvConfig
from slam.env.occupancy_grid import Extent
from slam.errors import ScenarioError
from slam.pose import FloatArray
from slam.scenario.lidar_config import LidarConfig, NoiseName
from slam.scenario.schema import Scenario
from slam.scenario.solids import obstacle_footprints

NO_NOISE, GAUSSIAN, REALISTIC = 0, 1, 2
_KINDS: Final[dict[NoiseName, int]] = {
    "none": NO_NOISE, "paper": GAUSSIAN, "datasheet": GAUSSIAN, "realistic": REALISTIC,
}  # fmt: skip

SENSOR: Final = np.dtype(
    [
        ("increment", "f8"),  # seconds from beam to beam
        ("noise", "i4"), ("near_sigma", "f8"), ("near_range", "f8"), ("far_sigma_per_metre", "f8"),
        ("dropout", "f8"), ("reflectivity", "f8"), ("sees_legs", "i4"),
    ],
    align=True,
)  # fmt: skip
"""The lidar of a scenario."""


class Worlds(NamedTuple):
    """W worlds, each with the robot, the lidar and the route of its scenario."""

    walls: WallPlan
    """Walls that the lidar sees."""
    obstacles: WallPlan
    """Walls that the robot can collide with."""
    crowd: Crowd
    models: NDArray[Any]
    """(W,): the records MODEL of the robots."""
    sensors: NDArray[Any]
    """(W,): the records SENSOR of the lidars."""
    mounts: FloatArray
    """(W, 2): x, y of the lidar on the base."""
    bearings: FloatArray
    """(W, B): bearings of the beams, base frame."""
    beams: FloatArray
    """(W, 2, B): unit vectors of the beams."""
    starts: FloatArray
    """(W, 3): start poses."""
    waypoints: FloatArray
    """(W, K, 2): way-points, K or fewer."""
    waypoint_counts: NDArray[np.int64]
    after: FloatArray
    """(W, K): length of the rest of the route from each way-point."""
    arrival: FloatArray
    """(W,): distance at which a way-point counts as reached, metres."""
    last_turn: NDArray[np.int64]
    """(W,): turns of the lidar after which an episode is truncated."""
    low: FloatArray
    """(W, 2): lower corner of the occupancy grid, metres."""
    grids: NDArray[np.int64]
    """(W, 2): rows and columns of the occupancy grid."""


class Timing(NamedTuple):
    """Lidar and clock, the same for all worlds of a batch."""

    range_min: float
    range_max: float
    resolution: float
    reach: float
    """Longest true range that noise may shorten to ``range_max``."""
    angle_increment: float
    """Radians from beam to beam."""
    beams_vary: int
    """Largest difference in the number of beams per turn; not 0 only for lidars that measure a full turn."""
    whole_turn: bool
    scan_time: float
    controls_before: int
    """Control steps from one scan to the first beam of the next."""
    controls_in_sweep: int
    """Control steps while the beams fire."""
    period: float
    """Seconds per control step."""


def timing_of(scenario: Scenario) -> Timing:
    """Read lidar and clock from a scenario."""
    model, clock = scenario.lidar.description, scenario.clock
    lidar = model.lidar
    reach = float(lidar.range_max + model.accuracy(np.array(lidar.range_max)))
    return Timing(
        lidar.range_min, lidar.range_max, model.resolution, reach, lidar.angle_increment,
        model.beams_vary, lidar.whole_turn, lidar.scan_time,
        clock.controls_per_scan - clock.controls_per_sweep, clock.controls_per_sweep, clock.control_period,
    )  # fmt: skip


def worlds_of(scenarios: Sequence[Scenario], config: EnvConfig) -> Worlds:
    """Make the arrays of these scenarios; ScenarioError if they differ in lidar or clock."""
    timing = timing_of(scenarios[0])
    if any(timing_of(scenario) != timing for scenario in scenarios):
        raise ScenarioError(f"{scenarios[0].name}: lidar.model, physics.rate and robot.control_rate cannot be random")
    lidars = [scenario.lidar for scenario in scenarios]
    bearings = np.array([lidar.mount.theta + lidar.description.lidar.angles for lidar in lidars])
    routes = [_route(scenario) for scenario in scenarios]
    most = max(len(points) for points, _ in routes)
    waypoints, after = np.zeros((len(routes), most, 2)), np.zeros((len(routes), most))
    for w, (points, left) in enumerate(routes):
        waypoints[w, : len(points)], after[w, : len(left)] = points, left
    extents = [Extent.of(scenario) for scenario in scenarios]
    prisms = [scenario.world.prisms() for scenario in scenarios]
    return Worlds(
        walls=wall_plan([scenario.world.outlines(scenario.lidar.height) for scenario in scenarios], timing.reach),
        obstacles=wall_plan([obstacle_footprints(solids) for solids in prisms], RADIUS),
        crowd=crowd_of([scenario.people for scenario in scenarios]),
        models=np.concatenate([model_of(scenario.robot, scenario.physics.rate) for scenario in scenarios]),
        sensors=np.array([_sensor(lidar) for lidar in lidars], SENSOR),
        mounts=np.array([lidar.mount.pose.translation for lidar in lidars]),
        bearings=bearings,
        beams=np.stack([np.cos(bearings), np.sin(bearings)], axis=1),
        starts=np.array([scenario.robot.start.pose.as_array() for scenario in scenarios]),
        waypoints=waypoints,
        waypoint_counts=np.array([len(points) for points, _ in routes], np.int64),
        after=after,
        arrival=np.array([scenario.route.arrival for scenario in scenarios]),
        last_turn=np.array([_last_turn(scenario, config, timing.scan_time) for scenario in scenarios], np.int64),
        low=np.array([extent.low for extent in extents]),
        grids=np.array([extent.shape(config.cell) for extent in extents], np.int64),
    )


def _sensor(lidar: LidarConfig) -> tuple[float, ...]:
    model, sigmas = lidar.description, lidar.bound_sigmas
    table_1 = model.near_accuracy, model.near_range, model.far_accuracy
    near, near_range, far = (model.noise or table_1) if lidar.noise == "datasheet" else table_1
    return (
        lidar.time_increment, _KINDS[lidar.noise], near / sigmas, near_range, far / sigmas,
        lidar.dropout, lidar.reflectivity, lidar.height <= LEG_HEIGHT,
    )  # fmt: skip


def _route(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return the way-points (K, 2), and the length of the rest of the route from each (K,)."""
    points = scenario.route.waypoints
    lengths = [hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points)]
    after = np.append(np.cumsum(lengths[::-1])[::-1], 0.0) if points else np.empty(0)
    return np.array(points, np.float64).reshape(-1, 2), after


def _last_turn(scenario: Scenario, config: EnvConfig, scan_time: float) -> int:
    seconds = min(scenario.duration, config.max_seconds or scenario.duration)
    return max(2, int(seconds / scan_time + 1e-9))
