"""The simulated robot behind the ``Robot`` protocol."""

import numpy as np

from sim.rays import ScanMotion
from sim.robot_in_world import RobotInWorld
from slam.closing import Closing
from slam.errors import RobotError
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray
from slam.robot import Observation, Restartable, Robot
from slam.scenario.schema import Scenario


class SimRobot(RobotInWorld, Closing):
    """A P3-DX with a planar lidar in a PyBullet world of its own.

    Simulated time passes in ``observe`` only. The same seed and commands give the same observations, bit by bit.
    """

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.T_base_laser = scenario.lidar.mount.pose
        self._clock = scenario.clock
        self._last_step = round(scenario.duration * self._clock.rate)
        super().__init__(scenario, scenario.robot, self._clock.rate)
        self._world.save()
        self.restart(scenario.seed if seed is None else seed)

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        self._world.close()

    def restart(self, seed: int) -> None:
        """Back to the start of the same scenario with another seed: all is as in a new SimRobot, but made faster."""
        self._require_open()
        self._furniture.park_far_away()
        self._base.park_far_away()
        self._world.restore()
        self._base.restart()
        self._people.restart()
        self._begin(seed)

    @property
    def furniture(self) -> FloatArray:
        """Present poses of the furniture that can be pushed: x, y, theta, map frame, metres, radians, shape (M, 3)."""
        return self._furniture.places

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Let the time of one scan pass, and take it; None when the scenario's duration is over.

        ``timeout`` has no meaning here: the simulation computes the next scan for as long as it takes.
        """
        self._require_open()
        clock = self._clock
        if self._world.steps + clock.steps_per_scan > self._last_step:
            return None
        for _ in range(clock.controls_per_scan - clock.controls_per_sweep):
            self._control_step()
        stamp, T_map_base, T_odom_base = self._world.time, self._base.pose, self._wheels.pose
        twist = self._wheels.mean_twist(stamp)
        sonar = self._read_sonar(T_map_base)
        motion = self._sweep()
        if clock.controls_per_sweep:
            twist = self._wheels.mean_twist(self._world.time)
        scan = self._lidar.scan(motion, stamp, self._lidar_rng)
        collided, bumpers = self._bumpers.read()
        odometry = Odometry(stamp, T_odom_base, twist)
        people = tuple((x, y) for x, y in self._people.positions.tolist())
        return Observation(scan, odometry, T_map_base, collided, self._base.stalled, bumpers, sonar, people)

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return it as clipped to the limits; two simulated seconds later the robot stops."""
        self._require_open()
        return self._base.command(command)

    def _sweep(self) -> ScanMotion:
        """Let the time of the beams pass; what moved meanwhile, one row for each control step.

        Between two rows the beams' poses are interpolated: at the default limits and rate that straightens the way by
        0.02 mm and 0.06 mrad.
        """
        path, legs, things = [self._base.place], [self._people.legs], [self._furniture.places]
        for _ in range(self._clock.controls_per_sweep):
            self._control_step()
            path.append(self._base.place)
            legs.append(self._people.legs)
            things.append(self._furniture.places)
        return ScanMotion(np.array(path), np.array(legs), self._clock.control_period, np.array(things))

    def _control_step(self) -> None:
        self._base.control()
        self._advance(self._clock.steps_per_control)

    def _require_open(self) -> None:
        if self._world.closed:
            raise RobotError("the simulated robot is closed; make a new SimRobot")


_: type[Robot] = SimRobot
_restartable: type[Restartable] = SimRobot
