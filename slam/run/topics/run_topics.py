"""A run on topics: every step turned into messages, as REP 103 and REP 105 have them."""

from math import inf
from pathlib import Path
from time import monotonic
from typing import Final

from slam.assets import P3DX_URDF, asset
from slam.closing import Closing
from slam.files.ros import messages as ros
from slam.files.ros.live_encoder import LiveEncoder
from slam.line_slam import Estimate
from slam.pose import FloatArray
from slam.run.estimator import DeadReckoning, Estimator
from slam.run.occupancy import occupancy
from slam.run.results.run_record import RunRecord
from slam.run.results.step_messages import StepMessages
from slam.run.step import Step
from slam.run.topics.map_topics import PERIOD, MapNews, MapTopics
from slam.run.topics.wheel_joints import WHEEL_JOINTS, WheelJoints
from slam.scenario.schema import Scenario
from slam.topics import names
from slam.topics.topic import Bus

_BATTERY_PERIOD: Final = 1.0
"""Seconds between two states of the battery."""


class RunTopics(Closing):
    """A watcher that publishes a run: the transforms before the scan that needs them, all with its stamp.

    The pose is published as map -> odom, odom -> base_link and base_link -> laser. Dead reckoning has no map: then
    another SLAM may have the topics of one, and the transform from map.
    """

    def __init__(self, bus: Bus, slam: Estimator, scenario: Scenario, messages: StepMessages) -> None:
        self._bus, self._slam, self._step_messages = bus, slam, messages
        self._encoder, self._joints = LiveEncoder(), WheelJoints(scenario.robot.odometry)
        self._mapping = None if isinstance(slam, DeadReckoning) else MapTopics(bus, scenario.slam, slam.T_base_laser)
        self._stamp, self._battery_due, self._lines_due = -inf, -inf, 0.0

    def on_step(self, step: Step) -> None:
        """Publish one step."""
        first, self._stamp = self._stamp == -inf, step.observation.scan.stamp
        if first:
            self._publish_description()
        self._bus.publish(names.CLOCK, self._stamp, self._encoder.clock(self._stamp))
        self._publish_robot(step)
        if self._mapping is not None:
            self._publish_pose(step.estimate)
            self._mapping.add(MapNews(step, self._lines_now()))

    def show_end(self, folder: Path) -> None:
        """Publish the map of the run that is in the folder, as it is known in the end and as it is exported."""
        if self._mapping is not None and self._stamp > -inf:
            self._mapping.close()
            record = RunRecord.open(folder)
            self._mapping.send_map(self._stamp, occupancy(record))
            self._mapping.send_lines(self._stamp, record.walls)

    def close(self) -> None:
        """End the thread of the map."""
        if self._mapping is not None:
            self._mapping.close()

    def _publish_description(self) -> None:
        mount = self._encoder.transforms(self._stamp, ("base_link", "laser", self._slam.T_base_laser))
        self._bus.publish(names.TF_STATIC, self._stamp, mount)
        urdf = asset(P3DX_URDF).read_text(encoding="utf-8")
        self._bus.publish(names.ROBOT_DESCRIPTION, self._stamp, self._encoder.text(urdf))

    def _publish_robot(self, step: Step) -> None:
        """Publish what a robot without SLAM has too, and the transform from the map where there is one."""
        stamp, seen, encoded = self._stamp, step.observation, self._step_messages.of(step)
        links = encoded[ros.TF]
        if self._mapping is None:
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

    def _publish_pose(self, estimate: Estimate) -> None:
        pose = self._encoder.unsure_pose(self._stamp, estimate.T_map_base, estimate.covariance)
        self._bus.publish(names.SLAM_POSE, self._stamp, pose)

    def _lines_now(self) -> FloatArray | None:
        """The lines of the map, where it is time to look at them."""
        if monotonic() < self._lines_due:
            return None
        self._lines_due = monotonic() + PERIOD
        return self._slam.lines.ends
