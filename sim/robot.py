"""The simulated robot behind the ``Robot`` protocol."""

from sim.robot_in_world import robot_in_world
from slam.closing import Closing
from slam.errors import RobotError
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray
from slam.robot import Observation, Restartable, Robot
from slam.scenario.schema import Scenario


class SimRobot(Closing):
    """A P3-DX with a planar lidar in its own world, moved by the scenario's ``physics.engine``.

    Simulated time passes in ``observe`` only. The same seed and commands give the same observations, bit by bit.
    """

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.T_base_laser = scenario.lidar.mount.pose
        self._clock = scenario.clock
        self._last_step = round(scenario.duration * self._clock.rate)
        self._body = robot_in_world(scenario, scenario.robot, self._clock.rate)
        self.restart(scenario.seed if seed is None else seed)

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        self._body.close()

    def restart(self, seed: int) -> None:
        """Return to the start of the same scenario with another seed.

        The result equals a new SimRobot, but is faster.
        """
        self._require_open()
        self._body.restart(seed)

    @property
    def furniture(self) -> FloatArray:
        """Present poses of the furniture that can be pushed: x, y, theta, map frame, metres, radians, shape (M, 3)."""
        return self._body.furniture

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Let the time of one scan pass, and take the scan; None once the scenario's duration is over.

        ``timeout`` has no effect: the simulation computes the next scan for as long as it takes. The poses of the beams
        are interpolated between control steps; at the default limits and rate the error of this is at most 0.02 mm and
        0.06 mrad.
        """
        self._require_open()
        body, clock = self._body, self._clock
        if body.steps + clock.steps_per_scan > self._last_step:
            return None
        body.advance(clock.controls_per_scan - clock.controls_per_sweep)
        stamp, T_map_base, T_odom_base, twist = body.time, body.pose, body.odometry, body.mean_twist()
        sonar = body.read_sonar()
        motion = body.sweep(clock.controls_per_sweep)
        if clock.controls_per_sweep:
            twist = body.mean_twist()
        scan = body.lidar.scan(motion, stamp, body.lidar_rng)
        collided, bumpers = body.read_bumpers()
        odometry = Odometry(stamp, T_odom_base, twist)
        people = tuple(map(tuple, body.people.tolist()))
        return Observation(scan, odometry, T_map_base, collided, body.stalled, bumpers, sonar, people)

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return it clipped to the limits.

        Without another command the robot stops after two seconds.
        """
        self._require_open()
        return self._body.command(command)

    def _require_open(self) -> None:
        if self._body.closed:
            raise RobotError("the simulated robot is closed; make a new SimRobot")


_: type[Robot] = SimRobot
_restartable: type[Restartable] = SimRobot
