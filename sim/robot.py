"""The simulated robot behind the ``Robot`` protocol."""

import numpy as np

from sim.bumpers import Bumpers
from sim.furniture import Furniture
from sim.p3dx import P3dx
from sim.people import People
from sim.rays import Sweep
from sim.sonar import SonarRing
from sim.urg04lx import Urg04lx
from sim.wheel_odometry import WheelOdometry
from sim.world import World
from slam.closing import Closing
from slam.errors import RobotError
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation, Restartable, Robot
from slam.scenario.schema import Scenario


class SimRobot(Closing):
    """A P3-DX with a planar lidar in a PyBullet world of its own.

    Simulated time passes in ``observe`` only. The same seed and commands give the same observations, bit by bit.
    """

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.T_base_laser = scenario.lidar.mount.pose
        self._clock = scenario.clock
        self._last_step = round(scenario.duration * self._clock.rate)
        self._wheel_errors = scenario.robot.odometry
        movables = scenario.world.movables()
        self._world = World(scenario.world.fixed_prisms(), self._clock.rate)
        self._base = P3dx(self._world, scenario.robot)
        self._people = People(self._world, scenario.people)
        self._furniture = Furniture(self._world, movables)
        self._lidar = Urg04lx(self._world, scenario.lidar, self._people.leg_radii, movables)
        self._sonar = SonarRing(self._world, movables) if scenario.robot.sonar else None
        self._world.save()
        self.restart(scenario.seed if seed is None else seed)

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        self._world.close()

    def restart(self, seed: int) -> None:
        """Back to the start of the same scenario with another seed: all is as in a new SimRobot, but made faster."""
        self._require_open()
        self._lidar_rng, odometry_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
        self._furniture.send_away()
        self._base.send_away()
        self._world.restore()
        self._base.restart()
        self._people.restart()
        self._bumpers = Bumpers()
        self._odometry = WheelOdometry(self._wheel_errors, self._base.read_encoders(), odometry_rng)

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
        stamp, T_map_base, T_odom_base = self._world.time, self._base.pose, self._odometry.pose
        twist = self._odometry.mean_twist(stamp)
        sonar = self._read_sonar(T_map_base)
        sweep = self._sweep()
        if clock.controls_per_sweep:
            twist = self._odometry.mean_twist(self._world.time)
        scan = self._lidar.scan(sweep, stamp, self._lidar_rng)
        collided, bumpers = self._bumpers.read()
        odometry = Odometry(stamp, T_odom_base, twist)
        people = tuple((x, y) for x, y in self._people.positions.tolist())
        return Observation(scan, odometry, T_map_base, collided, self._base.stalled, bumpers, sonar, people)

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return it as clipped to the limits; two simulated seconds later the robot stops."""
        self._require_open()
        return self._base.command(command)

    def _read_sonar(self, T_map_base: Pose2D) -> tuple[float, ...]:
        if self._sonar is None:
            return ()
        return self._sonar.read(T_map_base, self._people.legs, self._people.leg_radii, self._furniture.places)

    def _sweep(self) -> Sweep:
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
        return Sweep(np.array(path), np.array(legs), self._clock.control_period, np.array(things))

    def _control_step(self) -> None:
        world, base = self._world, self._base
        base.control()
        for _ in range(self._clock.steps_per_control):
            world.step()
            if contacts := base.contacts():
                self._bumpers.add(contacts, base.place)
        self._odometry.add(base.read_encoders())
        if self._people:
            self._people.step(base.place[:2], self._clock.control_period)

    def _require_open(self) -> None:
        if self._world.closed:
            raise RobotError("the simulated robot is closed; make a new SimRobot")


_: type[Robot] = SimRobot
_restartable: type[Restartable] = SimRobot
