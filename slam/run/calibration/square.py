"""UMBmark's squares: sides and quarter turns by odometry alone, clockwise and counter-clockwise.

Borenstein and Feng, IEEE T-RA 12(6), 1996: different errors of the wheels open or close the squares of the two
directions in different ways, so driving both directions separates the errors.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import copysign, pi
from typing import Final

from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D, stack_poses, wrap_angle
from slam.robot import Observation, Robot
from slam.run.calibration.wheel_fit import Leg

_NEAR, _ALIGNED = 0.005, 0.01
"""A side is over this near its end, metres, a turn this near its heading, radians. The motion is measured, so legs need
not be exact."""
_SLOWEST: Final = Twist2D(0.02, 0.04)
_STILL: Final = 3
"""Number of scans without motion after which scan and odometry surely belong to the same pose."""


@dataclass(frozen=True, slots=True)
class Square:
    """Square to drive: metres, m/s and rad/s; ``laps`` in each direction."""

    size: float = 2.0
    laps: int = 2
    speed: float = 0.3
    turn_speed: float = 0.5

    @property
    def turns(self) -> Iterator[float]:
        """The turn after each side, radians: first all to the right, then all to the left."""
        for turn in (-pi / 2.0, pi / 2.0):
            yield from [turn] * (4 * self.laps)


class SquareDrive:
    """Drives a robot leg by leg; ``locate`` returns the pose of the base at an observation."""

    def __init__(self, robot: Robot, locate: Callable[[Observation], Pose2D]) -> None:
        self._robot = robot
        self._locate = locate
        self._odometry, self._truth = self._look()

    def drive(self, square: Square) -> Iterator[Leg]:
        """Drive sides and turns in order; RobotError if the robot touches something, or gives no more scans."""
        heading = self._odometry.theta
        for turn in square.turns:
            yield self._leg(partial(self._ahead, square, heading))
            heading = wrap_angle(heading + turn)
            yield self._leg(partial(self._around, square, heading))

    def _leg(self, command: Callable[[Pose2D], Twist2D]) -> Leg:
        begin, still = self._odometry, 0
        odometry, truth = [begin], [self._truth]
        while still < _STILL:
            wanted = command(begin)
            self._robot.drive(wanted)
            before = self._odometry
            self._odometry, self._truth = self._look()
            odometry.append(self._odometry)
            truth.append(self._truth)
            moved = before.between(self._odometry)
            resting = wanted == Twist2D() and moved.distance(Pose2D()) < 1e-3 and abs(moved.theta) < 2e-3
            still = still + 1 if resting else 0
        return Leg(stack_poses(odometry), stack_poses(truth))

    def _ahead(self, square: Square, heading: float, begin: Pose2D) -> Twist2D:
        left = square.size - begin.distance(self._odometry)
        if left < _NEAR:
            return Twist2D()
        return Twist2D(min(square.speed, max(_SLOWEST.linear, left)), wrap_angle(heading - self._odometry.theta))

    def _around(self, square: Square, heading: float, _: Pose2D) -> Twist2D:
        left = wrap_angle(heading - self._odometry.theta)
        if abs(left) < _ALIGNED:
            return Twist2D()
        return Twist2D(0.0, copysign(min(square.turn_speed, max(_SLOWEST.angular, abs(left))), left))

    def _look(self) -> tuple[Pose2D, Pose2D]:
        observation = self._robot.observe()
        if observation is None:
            raise RobotError("the robot gives no more scans, and the squares are not finished")
        if observation.collided:
            raise RobotError("the robot touched something; give it more room, or choose a smaller --size")
        return observation.odometry.T_odom_base, self._locate(observation)
