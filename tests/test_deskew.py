"""Deskewing of scans of the simulated robot with a turning lidar."""

import numpy as np
import pytest

from sim.robot import SimRobot
from slam.deskew import deskewed
from slam.line_slam import LineSlam
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario

HALF_X, HALF_Y = 1.6, 1.2  # of the room, inside


@pytest.fixture(scope="module")
def room() -> Scenario:
    """A bare room that is seen whole from its middle."""
    corners = "[[-1.6, -1.2], [1.6, -1.2], [1.6, 1.2], [-1.6, 1.2]]"
    walls = f"world.walls=[{{points: {corners}, closed: true, thickness: 1e-3}}]"
    empty = ["world.boxes=[]", "world.tables=[]", "route.waypoints=[]"]
    return load_scenario("corridor", [walls, *empty, "lidar.noise=none", "lidar.caster=exact"])


@pytest.fixture(scope="module")
def turning(room: Scenario) -> list[Observation]:
    """Four seconds on the spot at up to 90 degrees a second, to and fro."""
    with SimRobot(room, 1) as robot:
        seen = []
        for k in range(40):
            robot.drive(Twist2D(0.0, 1.5 if k % 20 < 12 else -1.5))
            observation = robot.observe()
            assert observation is not None
            seen.append(observation)
    return seen


def off_the_walls(observation: Observation, room: Scenario, straighten: bool) -> float:
    """Root mean square distance of the points from the room's walls, at the true pose of the stamp."""
    scan, T_base_laser = observation.scan, room.lidar.mount.pose
    if straighten:
        scan = deskewed(scan, observation.odometry.twist, T_base_laser)
    assert observation.T_map_base is not None
    x, y = (observation.T_map_base @ T_base_laser).transform(scan.points()).T
    off = np.minimum(np.abs(np.abs(x) - HALF_X), np.abs(np.abs(y) - HALF_Y))
    return float(np.sqrt(np.mean(off**2)))


def test_deskewed_points_of_a_turning_lidar_lie_on_walls(room: Scenario, turning: list[Observation]) -> None:
    raw = np.mean([off_the_walls(observation, room, straighten=False) for observation in turning])
    straight = np.mean([off_the_walls(observation, room, straighten=True) for observation in turning])
    assert raw > 0.02  # metres: the fan is bent by up to 6 degrees
    assert straight < raw / 5


def test_deskewing_improves_the_heading(room: Scenario, turning: list[Observation]) -> None:
    def worst_heading(deskew: bool) -> float:
        slam = LineSlam(room.slam.model_copy(update={"deskew": deskew}), room.lidar.mount.pose, turning[0].T_map_base)
        errors = []
        for observation in turning:
            estimate = slam.update(observation.scan, observation.odometry)
            assert observation.T_map_base is not None
            errors.append(abs(observation.T_map_base.between(estimate.T_map_base).theta))
        return max(errors)

    assert worst_heading(deskew=True) < worst_heading(deskew=False) / 3
