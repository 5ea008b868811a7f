"""Views of an agent, by name: each has a space, and makes a new array of every state."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.occupancy_grid import Extent, OccupancyGrid
from slam.env.step_state import StepState
from slam.run.gym_arrays import odometry_array, odometry_space, scan_array, scan_space
from slam.scenario.schema import Scenario

_POSE_BOUND: Final = np.array([1e4, 1e4, np.pi], np.float32)
"""Bounds of x, y (m), theta (rad) that no world exceeds."""
_FARTHEST_GOAL: Final = 2e4
"""Distance that no way-point exceeds, metres."""
_GREY: Final = np.array([0, 127, 255], np.uint8)
"""Grey levels of UNKNOWN, FREE and WALL cells."""


@dataclass(frozen=True, slots=True)
class ViewSetup:
    """World of an episode, and the arguments of the environment that views depend on."""

    scenario: Scenario
    extent: Extent
    cell: float
    map_cells: int
    goal_as: Literal["polar", "xy"]


@dataclass(frozen=True, slots=True)
class View:
    """One key of the observations of one episode."""

    space: Box
    """Bounds, shape and type of the arrays."""
    of: Callable[[StepState], NDArray[Any]]
    """Make the array of a state, as a new array."""


def scan_view(setup: ViewSetup) -> View:
    """Ranges (beams,), metres, within [0, range_max], always finite; the fan is that of the model."""
    lidar = setup.scenario.lidar.description.lidar
    return View(scan_space(lidar), lambda state: scan_array(state.observation.scan, lidar))


def odometry_view(setup: ViewSetup) -> View:
    """x, y (m), theta (rad), v (m/s), omega (rad/s) of the wheel odometry, from the robot's start."""
    return View(odometry_space(), lambda state: odometry_array(state.observation.odometry))


def slam_pose_view(setup: ViewSetup) -> View:
    """x, y (m), theta (rad) of the pose that SLAM estimates, map frame."""

    def pose(state: StepState) -> NDArray[np.float32]:
        return np.clip(state.estimated_pose.as_array().astype(np.float32), -_POSE_BOUND, _POSE_BOUND)

    return View(Box(-_POSE_BOUND, _POSE_BOUND, dtype=np.float32), pose)


def map_view(setup: ViewSetup) -> View:
    """A square of cells (1, n, n) around the estimated pose, heading up: row 0 lies ahead, column 0 to the left.

    0 is unknown, 127 free, 255 a wall. Each scan is entered at the pose that SLAM had at the time.
    """
    grid = OccupancyGrid(setup.extent, setup.cell)
    T_base_laser = setup.scenario.lidar.mount.pose
    size = setup.map_cells
    offsets = (size / 2 - 0.5 - np.arange(size)) * setup.cell
    x, y = np.meshgrid(offsets, offsets, indexing="ij")
    centres = np.column_stack([x.ravel(), y.ravel()])  # base frame, (size^2, 2), row by row

    def square(state: StepState) -> NDArray[np.uint8]:
        grid.add_scan(state.observation.scan, state.estimated_pose @ T_base_laser)
        return _GREY[grid.at(state.estimated_pose.transform(centres))].reshape(1, size, size)

    return View(Box(0, 255, (1, size, size), np.uint8), square)


def goal_view(setup: ViewSetup) -> View:
    """The next way-point relative to the true pose, like a beacon; zeros if none is left.

    Distance (m) and bearing (rad), or x ahead and y to the left (m).
    """
    polar = setup.goal_as == "polar"
    high = np.array([_FARTHEST_GOAL, np.pi if polar else _FARTHEST_GOAL], np.float32)
    low = np.array([0.0 if polar else -_FARTHEST_GOAL, -high[1]], np.float32)

    def goal(state: StepState) -> NDArray[np.float32]:
        if state.goal is None:
            return np.zeros(2, np.float32)
        base = state.T_map_base
        if polar:
            return np.array([base.distance(state.goal), base.bearing(state.goal)], np.float32)
        relative = base.between(state.goal)
        return np.array([relative.x, relative.y], np.float32)

    return View(Box(low, high, dtype=np.float32), goal)


VIEWS: Final[dict[str, Callable[[ViewSetup], View]]] = {
    "scan": scan_view,
    "odometry": odometry_view,
    "slam_pose": slam_pose_view,
    "map": map_view,
    "goal": goal_view,
}
"""Every view by its name in the argument ``observe``."""
