"""Topics of the emulated robot: its devices' own measurements."""

import numpy as np

from hardware.emulator.emulator import EmulatorState
from slam.lidars import Lidar
from slam.line_slam import Estimate
from slam.odometry import Odometry, Twist2D
from slam.robot import Battery, Observation
from slam.run.estimator import DeadReckoning
from slam.run.results.step_messages import StepMessages
from slam.run.step import Step
from slam.run.topics.topic_session import TopicSession
from slam.scan import LaserScan
from slam.scenario.schema import Scenario


class EmulatorTopics:
    """Publishes states as topics, without a map.

    A scan has the newest range in every direction, at most one turn old.
    """

    def __init__(self, topics: TopicSession, scenario: Scenario) -> None:
        robot = DeadReckoning(scenario.lidar.mount.pose, scenario.robot.start.pose)
        self._watcher = topics.watcher(robot, scenario, StepMessages())
        self._lidar = scenario.lidar.description.lidar
        self._last: EmulatorState | None = None
        self._index = 0

    def show(self, state: EmulatorState) -> None:
        """Publish a state, unless no time has passed since the last one."""
        last = self._last or state
        passed = state.stamp - last.stamp
        if self._last is not None and passed <= 0.0:
            return
        twist = Twist2D.from_motion(last.T_odom_base.between(state.T_odom_base), passed)
        odometry = Odometry(state.stamp, state.T_odom_base, twist)
        battery = Battery(state.volts)
        seen = Observation(
            _scan(state, self._lidar), odometry, state.T_map_base, stalled=state.stalled, battery=battery
        )
        estimate = Estimate(state.stamp, state.T_map_base)
        self._watcher.on_step(Step(self._index, seen, estimate, Twist2D(), 0.0))
        self._last, self._index = state, self._index + 1


def _scan(state: EmulatorState, lidar: Lidar) -> LaserScan:
    """The ranges in evenly spaced directions; nan where nothing is measured, or the laser is off."""
    first, second = state.bearings[:2].tolist()
    ranges = np.where(state.ranges > lidar.range_max, np.inf, state.ranges)
    return LaserScan(state.stamp, first, second - first, lidar.range_min, lidar.range_max, ranges, 0.0, lidar.scan_time)
