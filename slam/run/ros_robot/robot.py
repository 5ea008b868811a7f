"""A robot of ROS 2 behind the ``Robot`` protocol."""

import time
from contextlib import ExitStack
from dataclasses import replace
from math import inf, isfinite
from typing import Final, Self

from slam.closing import Closing
from slam.errors import RobotError, RobotTimeout
from slam.files.ros.encoder import Encoder
from slam.files.ros.messages import STAMPED_TWIST, TWIST
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation, Robot
from slam.run.ros_robot.heard_lidar import HeardLidar
from slam.run.ros_robot.heard_topics import HeardTopics
from slam.scan import LaserScan
from slam.scenario.schema import Scenario
from slam.topics.ros_bus import open_ros_bus
from slam.topics.topic import Bus, Topic

_FIRST: Final = 10.0
"""Seconds to wait for the first scan of a robot that is to drive."""
_DRIVING, _FOLLOWING = 4, 3000
"""Scans that may wait, for a program that drives by them and must not lag behind, and for one that only maps."""
_LATE: Final = 0.25
"""Seconds that a scan waits for its odometry."""
_STOPS: Final = 3
"""Number of stop commands at the end, in case one is lost."""
_HINT: Final = "is the robot in this ROS_DOMAIN_ID, and on this machine or in the ROS_AUTOMATIC_DISCOVERY_RANGE?"


class TopicRobot(Closing):
    """A robot with the topics that the scenario's section ``ros`` names; use it as a context manager.

    The run ends after the scenario's duration. Stamps are those of its messages. The odometry is that at the first beam
    of a scan, interpolated between two messages, and starts at 0 at the first scan; its twist is that of the messages.
    Commands are clipped to the scenario's limits. The robot must stop by itself without commands, as is usual in ROS.
    Up to four scans wait for a caller that observes less often than they arrive; it gets the oldest of them, or with
    ``newest`` the last.

    With ``follows`` other programs drive it, and five minutes of scans may wait. The mount of its lidar is then that of
    the robot's transforms, or else ``mount``; a robot that drives a scenario must have the mount of the scenario.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int | None = None,
        bus: Bus | None = None,
        follows: bool = False,
        mount: Pose2D | None = None,
        newest: bool = False,
    ) -> None:
        self.T_base_laser = mount or scenario.lidar.mount.pose
        self.T_odom_start = Pose2D()
        """``T_odom_base`` at the first scan, in the robot's own frame odom."""
        self._scenario, self._follows, self._newest = scenario, follows, newest
        self._bus, self._encoder = bus or open_ros_bus(), Encoder()
        self._commands = Topic(scenario.ros.command_topic, STAMPED_TWIST if scenario.ros.stamped_commands else TWIST)
        self._open = ExitStack()
        self._topics: HeardTopics | None = None
        self._lidar: HeardLidar | None = None
        self._first: float | None = None  # stamp of the first observation
        self._last: Observation | None = None

    def __enter__(self) -> Self:
        """Join the network; RobotError if a robot to drive is not found. An open robot stays open."""
        if self._topics is None:
            with ExitStack() as opening:
                opening.enter_context(self._bus)
                self._topics = HeardTopics(self._bus, self._scenario.ros, _FOLLOWING if self._follows else _DRIVING)
                opening.callback(self._leave)
                self._first = self._last = None
                if not self._follows:
                    self.meet(_FIRST)
                self._open = opening.pop_all()
        return self

    def meet(self, timeout: float = inf) -> None:
        """Wait for the first scan, and find its lidar and mount; RobotError if none comes."""
        self._lidar = HeardLidar.wait_for(self._opened(), time.monotonic() + timeout)
        if self._lidar is None:
            raise RobotError(f"no scan on {self._scenario.ros.scan_topic} for {timeout:g} s: {_HINT}")
        if self._follows:
            self.T_base_laser = self._lidar.place(otherwise=self.T_base_laser)
        else:
            self._lidar.require_place(self.T_base_laser)

    def close(self) -> None:
        """Stop the robot, if it was driven, and leave the network; closing twice is allowed."""
        self._open.close()

    @property
    def lidar(self) -> HeardLidar:
        """The lidar; RobotError before the first scan."""
        if self._lidar is None:
            raise RobotError("the lidar is not known before the robot is met")
        return self._lidar

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Wait for the next scan that has odometry; None once the scenario's duration is over.

        RobotTimeout says what did not come.
        """
        topics, until, alone = self._opened(), time.monotonic() + timeout, 0
        while not self._over and (raw := topics.next_scan(until, self._newest)) is not None:
            scan = self.lidar.read(raw)
            if scan is None:
                continue
            odometry = topics.odometry.at(scan.stamp, time.monotonic() + _LATE)
            if odometry is not None:
                self._last = self._observation(scan, odometry)
                return None if self._over else self._last
            alone += 1
        if self._over:
            return None
        raise RobotTimeout(self._silence(topics, timeout, alone))

    def drive(self, command: Twist2D) -> Twist2D:
        """Command a velocity, and return it clipped to the limits; if others drive, return the measured one."""
        self._opened()
        if not (isfinite(command.linear) and isfinite(command.angular)):
            raise RobotError(f"cannot drive at {command}: both speeds must be finite numbers")
        if self._follows:
            return self._last.odometry.twist if self._last is not None else Twist2D()
        limits = self._scenario.robot.limits
        v, w = limits.linear, limits.angular
        applied = Twist2D(min(max(command.linear, -v), v), min(max(command.angular, -w), w))
        self._send(applied)
        return applied

    def _leave(self) -> None:
        self._topics = None
        if not self._follows:
            for _ in range(_STOPS):
                self._send(Twist2D())

    @property
    def _over(self) -> bool:
        if self._first is None or self._last is None:
            return False
        scan = self._last.scan
        return scan.stamp - self._first > self._scenario.duration - scan.scan_time / 2.0

    def _observation(self, scan: LaserScan, odometry: Odometry) -> Observation:
        if self._first is None:
            self._first, self.T_odom_start = scan.stamp, odometry.T_odom_base
        return Observation(scan, replace(odometry, T_odom_base=self.T_odom_start.between(odometry.T_odom_base)))

    def _send(self, twist: Twist2D) -> None:
        stamp = self._last.scan.stamp if self._last is not None else 0.0
        stamped = self._commands.type == STAMPED_TWIST
        message = self._encoder.stamped_twist(stamp, twist) if stamped else self._encoder.twist(twist)
        self._bus.publish(self._commands, stamp, message)

    def _silence(self, topics: HeardTopics, timeout: float, alone: int) -> str:
        """Describe what did not come in time: scans, or odometry for scans that came ``alone``."""
        config, last = self._scenario.ros, topics.odometry.last
        if not alone:
            return f"no scan on {config.scan_topic} for {timeout:g} s"
        if last is None:
            return f"{alone} scans came, but no odometry on {config.odom_topic} or /tf"
        return f"{alone} scans came, but the odometry on {config.odom_topic} is of another time, {last.stamp:.3f} s"

    def _opened(self) -> HeardTopics:
        if self._topics is None:
            raise RobotError("the robot is closed; use it as a context manager: with TopicRobot(scenario) as robot")
        return self._topics


_: type[Robot] = TopicRobot
