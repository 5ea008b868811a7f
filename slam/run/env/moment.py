"""What there is to know after one scan."""

from __future__ import annotations

from dataclasses import dataclass

from slam.errors import RobotError
from slam.line_slam import Estimate
from slam.pose import Pose2D
from slam.robot import Observation


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """All that views, rewards and ends are made from."""

    observation: Observation
    T_map_base: Pose2D
    """The true pose."""
    T_map_laser: Pose2D
    """The true pose of the sensor."""
    goal: Pose2D | None
    """The next way-point; None when all are passed."""
    arrived: bool
    """Whether the last way-point was reached."""
    left: float
    """Metres of the route that are left."""
    estimate: Estimate | None
    """Of the method; None where it does not run."""

    @property
    def belief(self) -> Pose2D:
        """Where the method believes the robot is, map frame."""
        if self.estimate is None:
            raise RobotError("this environment runs no SLAM: ask for slam_pose or map in observe, or lost in end_on")
        return self.estimate.T_map_base

    @property
    def lost(self) -> bool:
        """Whether the method says itself that it is lost."""
        return self.estimate is not None and self.estimate.lost

    @property
    def slam_error(self) -> float:
        """Metres from the true to the estimated pose; 0 where the method does not run."""
        return 0.0 if self.estimate is None else self.T_map_base.distance(self.estimate.T_map_base)
