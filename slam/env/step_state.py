"""State of an episode after one scan, and the conditions that end an episode."""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from typing import Final, Literal

from slam.errors import RobotError
from slam.line_slam import Estimate
from slam.pose import Pose2D
from slam.robot import Observation


@dataclass(frozen=True, slots=True, eq=False)
class StepState:
    """Inputs of views, rewards and ends."""

    observation: Observation
    T_map_base: Pose2D
    """The true pose; the estimated one if the robot does not know the true pose."""
    T_map_laser: Pose2D
    """The pose of the sensor, from the same source."""
    goal: Pose2D | None
    """The next way-point; None when all are passed."""
    arrived: bool
    """True once the last way-point was reached."""
    route_left: float
    """Remaining length of the route, metres."""
    estimate: Estimate | None
    """Estimate of SLAM; None if it does not run."""

    @property
    def truth(self) -> Pose2D | None:
        """The true pose; None if the robot does not know it."""
        return self.observation.T_map_base

    @property
    def pose_source(self) -> Literal["truth", "estimate"]:
        """Source of ``T_map_base``."""
        return "estimate" if self.truth is None else "truth"

    @property
    def estimated_pose(self) -> Pose2D:
        """Pose that SLAM estimates, map frame."""
        if self.estimate is None:
            raise RobotError("this environment runs no SLAM: ask for slam_pose or map in observe, or lost in end_on")
        return self.estimate.T_map_base

    @property
    def lost(self) -> bool:
        """True if SLAM reports that it is lost."""
        return self.estimate is not None and self.estimate.lost

    @property
    def slam_error(self) -> float:
        """Distance of the estimated from the true pose, metres; nan without the true pose, 0 without SLAM."""
        if self.estimate is None:
            return 0.0
        return nan if self.truth is None else self.truth.distance(self.estimate.T_map_base)

    @property
    def collided(self) -> bool:
        """True if the robot touched anything but the floor, or a wheel is blocked."""
        return self.observation.collided or self.observation.stalled


ENDS: Final[dict[str, Callable[[StepState, float], bool]]] = {
    "collision": lambda state, lost_beyond: state.collided,
    "goal": lambda state, lost_beyond: state.arrived,
    "lost": lambda state, lost_beyond: state.lost or state.slam_error > lost_beyond,
}
"""Ends that may terminate an episode, by their names in the argument ``end_on``; ``lost_beyond`` in metres."""
