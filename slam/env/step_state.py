"""The state of an episode after one scan, and the ends that it may have come to."""

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
    """All that views, rewards and ends are made from."""

    observation: Observation
    T_map_base: Pose2D
    """The true pose; the estimate where the robot does not know the truth."""
    T_map_laser: Pose2D
    """The pose of the sensor, from the same source."""
    goal: Pose2D | None
    """The next way-point; None when all are passed."""
    arrived: bool
    """True when the last way-point was reached."""
    route_left: float
    """Metres of the route that are left."""
    estimate: Estimate | None
    """Estimate of the method; None where it does not run."""

    @property
    def truth(self) -> Pose2D | None:
        """The true pose; None where the robot does not know it."""
        return self.observation.T_map_base

    @property
    def pose_source(self) -> Literal["truth", "estimate"]:
        """Source of ``T_map_base``."""
        return "estimate" if self.truth is None else "truth"

    @property
    def estimated_pose(self) -> Pose2D:
        """Pose that the method estimates, map frame."""
        if self.estimate is None:
            raise RobotError("this environment runs no SLAM: ask for slam_pose or map in observe, or lost in end_on")
        return self.estimate.T_map_base

    @property
    def lost(self) -> bool:
        """True where the method says itself that it is lost."""
        return self.estimate is not None and self.estimate.lost

    @property
    def slam_error(self) -> float:
        """Metres from the true to the estimated pose; nan without the truth, 0 where the method does not run."""
        if self.estimate is None:
            return 0.0
        return nan if self.truth is None else self.truth.distance(self.estimate.T_map_base)

    @property
    def collided(self) -> bool:
        """True where the robot touched anything but the floor, or says that something holds its wheels."""
        return self.observation.collided or self.observation.stalled


ENDS: Final[dict[str, Callable[[StepState, float], bool]]] = {
    "collision": lambda state, lost_beyond: state.collided,
    "goal": lambda state, lost_beyond: state.arrived,
    "lost": lambda state, lost_beyond: state.lost or state.slam_error > lost_beyond,
}
"""Ends that may terminate an episode, by the name that the argument ``end_on`` gives it; ``lost_beyond`` in metres."""
