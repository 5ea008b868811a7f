"""SLAM as a node of ROS 2, on the topics of a robot that others drive."""

from collections.abc import Sequence

from slam.pose import Pose2D
from slam.run.estimator import Estimator
from slam.run.results.step_messages import StepMessages
from slam.run.ros_robot.robot import TopicRobot
from slam.run.topics.slam_topics import SlamTopics, StepNews
from slam.run.topics.topic_session import TopicSession
from slam.scenario.schema import Scenario
from slam.topics import names
from slam.topics.topic import Bus


class FollowerTopics(SlamTopics):
    """Watcher that publishes map -> odom, which joins the robot's own frames to the map, and the results of SLAM."""

    def __init__(
        self, bus: Bus, slam: Estimator, scenario: Scenario, messages: StepMessages, robot: TopicRobot
    ) -> None:
        super().__init__(bus, slam, scenario, messages)
        self._robot = robot

    def publish(self, news: StepNews) -> None:
        """Publish one step."""
        seen = news.step.observation
        links = "map", "odom", self._T_map_odom(news.step.estimate.T_map_base, seen.odometry.T_odom_base)
        self._bus.publish(names.TF, seen.scan.stamp, self._encoder.transforms(seen.scan.stamp, links))
        self.publish_estimate(news)

    def _T_map_odom(self, T_map_base: Pose2D, T_start_base: Pose2D) -> Pose2D:
        return T_map_base @ (self._robot.T_odom_start @ T_start_base).inverse()


class FollowerSession(TopicSession):
    """Buses on which SLAM publishes its results while the robot publishes its own topics."""

    def __init__(self, buses: Sequence[Bus], robot: TopicRobot) -> None:
        super().__init__(buses)
        self._robot = robot

    def make_watcher(self, slam: Estimator, scenario: Scenario, messages: StepMessages) -> FollowerTopics:
        """Make the watcher that publishes the results of SLAM."""
        return FollowerTopics(self.bus, slam, scenario, messages, self._robot)
