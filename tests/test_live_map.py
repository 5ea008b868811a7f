"""The occupancy grid of a run: it grows, and moves when a loop is closed."""

import numpy as np
from numpy.testing import assert_allclose

from slam.config import SlamConfig
from slam.graph.closure import Closure
from slam.line_slam import Estimate
from slam.mapping.surfel_map import SurfelMap
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.occupancy import Occupancy
from slam.run.step import Step
from slam.run.topics.live_map import LiveMap
from slam.run.topics.map_topics import MapTopics
from slam.scan import LaserScan
from slam.topics import names
from tests.topic_bus import ListBus

ORIGIN, MOUNT = Pose2D(), Pose2D(0.1, 0.0, 0.0)
CONFIG = SlamConfig()
MOVED = Pose2D(0.5, 0.25, 0.0)
"""A closure that moves the map by whole cells."""


def step(index: int, T_local_base: Pose2D, T_map_local: Pose2D = ORIGIN, closure: Closure | None = None) -> Step:
    ranges = np.random.default_rng(index).uniform(1.0, 3.0, 200)
    scan = LaserScan(0.1 * index, -2.0, 0.02, 0.06, 4.0, ranges)
    estimate = Estimate(scan.stamp, T_map_local @ T_local_base, T_map_local=T_map_local, closure=closure)
    return Step(index, Observation(scan, Odometry(scan.stamp, T_local_base)), estimate, Twist2D(), 0.0)


def closure(*placed: tuple[int, Pose2D]) -> Closure:
    """Puts the base at these places with these scans."""
    poses = np.array([(pose @ MOUNT).as_array() for _, pose in placed])
    indices = np.array([index for index, _ in placed])
    zero, loops = np.zeros(3), np.empty((0, 2), np.int64)
    return Closure(0, zero, zero, np.eye(3), SurfelMap(CONFIG.map), len(poses), (), poses, indices, loops)


def made_of(*steps: Step) -> Occupancy:
    live = LiveMap(CONFIG, MOUNT)
    for each in steps:
        live.add(each)
    assert live.grid is not None
    return live.grid


def centres(grid: Occupancy) -> np.ndarray:
    """Return the centres of the occupied cells, in order."""
    rows, columns = np.nonzero(grid.occupied)
    return grid.corner + grid.cell * (np.column_stack([columns, rows]) + 0.5)


def test_a_grown_grid_equals_a_large_grid() -> None:
    far = [step(k, Pose2D(3.0 * k, -2.0 * k, 0.1 * k)) for k in range(8)]
    there, back = made_of(*far), made_of(*reversed(far))
    assert there.hits.sum() == back.hits.sum() > 1000
    assert_allclose(centres(there), centres(back), atol=1e-6)


def test_a_closure_moves_the_counts() -> None:
    places = [Pose2D(1.0 * k, 0.0, 0.0) for k in range(5)]
    closed = closure((0, MOVED @ places[0]), (3, MOVED @ places[3]), (-1, Pose2D(50.0, 0.0, 0.0)))
    before = [step(k, place) for k, place in enumerate(places[:4])]
    moved = made_of(*before, step(4, places[4], MOVED, closed))
    whole = made_of(*(step(k, place, MOVED) for k, place in enumerate(places)))
    assert len(centres(moved)) > 200
    assert_allclose(centres(moved), centres(whole), atol=1e-6)


def test_a_standing_robot_adds_nothing() -> None:
    live = LiveMap(CONFIG, MOUNT)
    assert live.add(step(0, Pose2D()))
    assert not any(live.add(step(k, Pose2D(0.001 * k, 0.0, 0.0))) for k in range(1, 20))


def test_too_many_lines_are_sent_in_part() -> None:
    bus, ends = ListBus(), np.random.default_rng(0).uniform(size=(10_001, 2, 2))
    with MapTopics(bus, CONFIG, MOUNT) as topics:
        topics.add(step(0, ORIGIN), ends)
        topics.add(step(1, ORIGIN), ends)
    (heard,) = bus.of(names.LINES)
    (marker,) = heard.message.markers
    assert_allclose([(p.x, p.y) for p in marker.points[-2:]], ends[9999], atol=1e-12)
    assert len(marker.points) == 2 * 3334
