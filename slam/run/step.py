"""A step of a run, and the Watcher protocol."""

from dataclasses import dataclass
from typing import Protocol

from slam.line_slam import Estimate
from slam.odometry import Twist2D
from slam.robot import Observation


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One turn of the loop: a scan, its estimate, and the command before it."""

    index: int
    observation: Observation
    estimate: Estimate
    applied: Twist2D
    """The command during the motion to this scan, within the robot's limits; in a replay, the recorded one."""
    progress: float
    """Share of the route that is done, 0 to 1."""
    timeouts: int = 0
    """Number of times that the robot was silent for too long before this scan."""


class Watcher(Protocol):
    """Receives every step of a run, and changes nothing."""

    def on_step(self, step: Step) -> None:
        """Process one step."""
        ...
