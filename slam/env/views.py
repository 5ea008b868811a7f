"""What an agent sees, by name: each view gives its space, and a fresh array of every state."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.occupancy_grid import Extent, OccupancyGrid
from slam.env.step_state import StepState
from slam.pose import FloatArray
from slam.run.arrays import odometry_array, odometry_space, scan_array, scan_space
from slam.scenario.schema import Scenario

_POSE_BOUND: Final = np.array([1e4, 1e4, np.pi], np.float32)
"""Bounds of x, y (m), theta (rad) that no world exceeds."""
_FARTHEST_GOAL: Final = 2e4
"""Distance that no way-point exceeds, metres."""
_GREY: Final = np.array([0, 127, 255], np.uint8)
"""Grey levels of UNKNOWN, FREE and WALL cells."""


@dataclass(frozen=True, slots=True)
class ViewSetup:
    """The world of an episode, and those arguments of the environment that views are made from."""

    scenario: Scenario
    extent: Extent
    cell: float
    map_cells: int
    goal_as: Literal["polar", "xy"]


class View(Protocol):
    """One key of the observations of one episode."""

    def space(self) -> Box:
        """Bounds, shape and type of the arrays."""
        ...

    def of(self, state: StepState) -> NDArray[Any]:
        """Make the array of this state, which nobody else holds."""
        ...


class ScanView:
    """Ranges (beams,), metres, within [0, range_max], always finite."""

    def __init__(self, setup: ViewSetup) -> None:
        self._lidar = setup.scenario.lidar.description.lidar

    def space(self) -> Box:
        """[0, range_max] for each beam."""
        return scan_space(self._lidar)

    def of(self, state: StepState) -> NDArray[np.float32]:
        """The ranges of the last scan."""
        return scan_array(state.observation.scan)


class OdometryView:
    """x, y (m), theta (rad), v (m/s), omega (rad/s), as the wheels say, from where the robot started."""

    def space(self) -> Box:
        """Bounds of any robot of this kind."""
        return odometry_space()

    def of(self, state: StepState) -> NDArray[np.float32]:
        """The last odometry."""
        return odometry_array(state.observation.odometry)


class SlamPoseView:
    """x, y (m), theta (rad) of the pose that SLAM estimates, map frame."""

    def space(self) -> Box:
        """Bounds of any world."""
        return Box(-_POSE_BOUND, _POSE_BOUND, dtype=np.float32)

    def of(self, state: StepState) -> NDArray[np.float32]:
        """The last estimate."""
        return np.clip(state.estimated_pose.as_array().astype(np.float32), -_POSE_BOUND, _POSE_BOUND)


class MapView:
    """A square of cells (1, n, n) around the estimated pose, heading up: row 0 lies ahead, column 0 to the left.

    0 is unknown, 127 free, 255 a wall. The scans are put together at the poses that SLAM gave when they came.
    """

    def __init__(self, setup: ViewSetup) -> None:
        self._grid = OccupancyGrid(setup.extent, setup.cell)
        self._T_base_laser = setup.scenario.lidar.mount.pose
        self._size = setup.map_cells
        self._points = _cell_centres(setup.map_cells, setup.cell)

    def space(self) -> Box:
        """An image of one channel."""
        return Box(0, 255, (1, self._size, self._size), np.uint8)

    def of(self, state: StepState) -> NDArray[np.uint8]:
        """The square around the estimated pose."""
        self._grid.add_scan(state.observation.scan, state.estimated_pose @ self._T_base_laser)
        cells = self._grid.at(state.estimated_pose.transform(self._points))
        return _GREY[cells].reshape(1, self._size, self._size)


def _cell_centres(size: int, cell: float) -> FloatArray:
    """Centres of the cells around the robot, base frame, shape (size^2, 2), row by row."""
    offsets = (size / 2 - 0.5 - np.arange(size)) * cell
    x, y = np.meshgrid(offsets, offsets, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


class GoalView:
    """The next way-point from the true pose, as if a beacon stood there; zeros when none is left.

    Distance (m) and bearing (rad), or x ahead and y to the left (m).
    """

    def __init__(self, setup: ViewSetup) -> None:
        self._polar = setup.goal_as == "polar"

    def space(self) -> Box:
        """Distance and bearing, or two coordinates."""
        high = np.array([_FARTHEST_GOAL, np.pi if self._polar else _FARTHEST_GOAL], np.float32)
        low = np.array([0.0 if self._polar else -_FARTHEST_GOAL, -high[1]], np.float32)
        return Box(low, high, dtype=np.float32)

    def of(self, state: StepState) -> NDArray[np.float32]:
        """The next way-point from where the robot is."""
        if state.goal is None:
            return np.zeros(2, np.float32)
        base = state.T_map_base
        if self._polar:
            return np.array([base.distance(state.goal), base.bearing(state.goal)], np.float32)
        relative = base.between(state.goal)
        return np.array([relative.x, relative.y], np.float32)


VIEWS: Final[dict[str, Callable[[ViewSetup], View]]] = {
    "scan": ScanView,
    "odometry": lambda setup: OdometryView(),
    "slam_pose": lambda setup: SlamPoseView(),
    "map": MapView,
    "goal": GoalView,
}
"""Every view by the name that the argument ``observe`` gives it."""
