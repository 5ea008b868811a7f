"""Topics of a run: messages of every step, following REP 103 and REP 105."""

from collections.abc import Mapping
from math import inf
from typing import Final

from slam.assets import P3DX_URDF, asset
from slam.files.ros import messages as ros
from slam.robot import Observation
from slam.run.estimator import Estimator
from slam.run.results.step_messages import StepMessages
from slam.run.topics.slam_topics import SlamTopics, StepNews
from slam.run.topics.wheel_joints import WHEEL_JOINTS, WheelJoints
from slam.scenario.schema import Scenario
from slam.topics import names
from slam.topics.topic import Bus

_BATTERY_PERIOD: Final = 1.0
"""Seconds between two states of the battery."""


class RunTopics(SlamTopics):
    """Publishes the robot and its SLAM; the transforms have the stamp of the scan and are sent before it.

    The pose is published as map -> odom, odom -> base_link and base_link -> laser. With dead reckoning only, no map
    topics and no map -> odom are published; another SLAM node may do that.
    """

    def __init__(self, bus: Bus, slam: Estimator, scenario: Scenario, messages: StepMessages) -> None:
        super().__init__(bus, slam, scenario, messages)
        self._joints, self._battery_due = WheelJoints(scenario.robot.odometry), -inf

    def publish(self, news: StepNews) -> None:
        """Publish one step."""
        if news.step.index == 0:
            self._publish_description(news.step.observation.scan.stamp)
        self.publish_time(news.step.observation.scan.stamp)
        self._publish_robot(news.step.observation, news.messages)
        self.publish_estimate(news)

    def _publish_description(self, stamp: float) -> None:
        mount = self._encoder.transforms(stamp, ("base_link", "laser", self._slam.T_base_laser))
        self._bus.publish(names.TF_STATIC, stamp, mount)
        urdf = asset(P3DX_URDF).read_text(encoding="utf-8")
        self._bus.publish(names.ROBOT_DESCRIPTION, stamp, self._encoder.text(urdf))

    def _publish_robot(self, seen: Observation, encoded: Mapping[str, bytes]) -> None:
        """Publish the topics of a robot without SLAM, and the transform from the map if there is one."""
        stamp, links = seen.scan.stamp, encoded[ros.TF]
        if self._map_topics is None:
            links = self._encoder.transforms(stamp, ("odom", "base_link", seen.odometry.T_odom_base))
        self._bus.publish(names.TF, stamp, links)
        self._bus.publish(names.ODOM, stamp, encoded[ros.ODOM])
        self._bus.publish(names.SCAN, stamp, encoded[ros.SCAN])
        joints = self._joints
        joints.add(seen.odometry)
        message = self._encoder.joints(stamp, WHEEL_JOINTS, joints.angles, joints.speeds)
        self._bus.publish(names.JOINT_STATES, stamp, message)
        if stamp >= self._battery_due:
            self._battery_due = stamp + _BATTERY_PERIOD
            self._bus.publish(names.BATTERY_STATE, stamp, self._encoder.battery(stamp, seen.battery))
