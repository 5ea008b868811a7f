"""One episode: what is kept from scan to scan."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from slam.errors import RobotError
from slam.line_slam import LineSlam
from slam.robot import Observation
from slam.run.course import Course
from slam.run.env.config import EnvConfig
from slam.run.env.moment import Moment
from slam.run.env.rewards import make_reward
from slam.run.env.seen_grid import Extent
from slam.run.env.views import make_views
from slam.run.scenario.schema import Scenario


class Episode:
    """Begins with the first observation; ``moment`` is what the last one came to."""

    def __init__(self, config: EnvConfig, scenario: Scenario, extent: Extent, seed: int, first: Observation) -> None:
        self.config, self.scenario = config, scenario
        start, mount = scenario.robot.start.pose, scenario.lidar.mount.pose
        self._T_base_laser = mount
        self._course = Course(start, scenario.route.waypoints, scenario.route.arrival)
        self.slam = LineSlam(scenario.slam, mount, start, seed) if config.uses_slam else None
        self._views = make_views(config, scenario, extent)
        self._scan_time = scenario.lidar.description.lidar.scan_time
        seconds = min(scenario.duration, config.max_seconds or scenario.duration)
        self._last_scan = max(2, int(seconds / self._scan_time + 1e-9))
        self._scans = 0
        self.moment = self.see(first)
        self.reward = make_reward(config, extent, self.moment)

    @property
    def seconds(self) -> float:
        """Simulated time since the robot was put down."""
        return self._scans * self._scan_time

    @property
    def out_of_time(self) -> bool:
        """Whether this was the last scan for which there is time."""
        return self._scans >= self._last_scan

    def see(self, observation: Observation) -> Moment:
        """Take the next observation in: along the route, and through SLAM where it is needed."""
        self._scans += 1
        truth = observation.T_map_base
        if truth is None:
            raise RobotError("rewards and ends need the true pose, which this robot does not know")
        self._course.advance(truth)
        estimate = self.slam.update(observation.scan, observation.odometry) if self.slam else None
        T_map_laser, course = truth @ self._T_base_laser, self._course
        self.moment = Moment(observation, truth, T_map_laser, course.goal, course.arrived, course.left, estimate)
        return self.moment

    def views(self) -> dict[str, NDArray[Any]]:
        """What the agent sees of this moment, in fresh arrays."""
        return {name: view.of(self.moment) for name, view in self._views.items()}

    def payment(self) -> dict[str, float]:
        """The parts that the reward of this moment is the sum of."""
        collided = self.moment.observation.collided
        return {
            self.config.reward: self.reward.of(self.moment),
            "collision": -self.config.collision_penalty if collided else 0.0,
        }
