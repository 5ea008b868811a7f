"""The simulated robot behind the ``Robot`` protocol."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import numpy as np

from sim.p3dx import P3dx
from sim.urg04lx import Urg04lx
from sim.wheel_odometry import WheelOdometry
from sim.world import World
from slam.errors import RobotError
from slam.odometry import Twist2D
from slam.robot import Observation, Robot
from slam.run.scenario.schema import Scenario


class SimRobot:
    """A P3-DX with a planar lidar in a PyBullet world of its own.

    Simulated time passes in ``observe`` only. The same seed and commands give the same observations, bit by bit.
    """

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.T_base_laser = scenario.lidar.mount.pose
        self._steps_per_scan = scenario.steps_per_scan
        self._last_step = round(scenario.duration * scenario.physics.rate)
        seeds = np.random.SeedSequence(scenario.seed if seed is None else seed)
        self._lidar_rng, odometry_rng = map(np.random.default_rng, seeds.spawn(2))
        self._world = World(scenario.world.prisms(), scenario.physics.rate)
        self._base = P3dx(self._world, scenario.robot.start.pose, scenario.robot.limits)
        self._lidar = Urg04lx(self._world, scenario.lidar)
        self._odometry = WheelOdometry(scenario.robot.odometry, self._base.read_encoders(), odometry_rng)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        self._world.close()

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Let the time of one scan pass, and take it; None when the scenario's duration is over.

        ``timeout`` has no meaning here: the simulation computes the next scan for as long as it takes.
        """
        self._require_open()
        if self._world.steps + self._steps_per_scan > self._last_step:
            return None
        collided = self._advance()
        stamp, T_map_base = self._world.time, self._base.pose
        scan = self._lidar.scan(T_map_base @ self.T_base_laser, stamp, self._lidar_rng)
        return Observation(scan, self._odometry.read(stamp), T_map_base, collided)

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return it as clipped to the limits; two simulated seconds later the robot stops."""
        self._require_open()
        return self._base.command(command)

    def _advance(self) -> bool:
        """Step the physics until the next scan; whether the robot touched anything on the way."""
        collided = False
        for _ in range(self._steps_per_scan):
            self._base.control()
            self._world.step()
            self._odometry.add(self._base.read_encoders())
            collided |= self._base.collided
        return collided

    def _require_open(self) -> None:
        if self._world.closed:
            raise RobotError("the simulated robot is closed; make a new SimRobot")


_: type[Robot] = SimRobot
