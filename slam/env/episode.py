"""One episode: what is kept from scan to scan."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from slam.env.config import EnvConfig
from slam.env.rewards import make_reward
from slam.env.seen_grid import Extent
from slam.env.step_state import StepState
from slam.env.views import make_views
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.estimator import Estimator, make_estimator
from slam.run.pilots import RouteProgress
from slam.scenario.schema import Scenario


class Episode:
    """One episode, which begins with the first observation, at the pose ``start``.

    ``moment`` holds all that is known after the last observation.

    The method runs where the configuration needs it, and where the robot does not know the truth.
    """

    def __init__(
        self, config: EnvConfig, scenario: Scenario, extent: Extent, seed: int, start: Pose2D, first: Observation
    ) -> None:
        self.config, self.scenario = config, scenario
        self.start = start
        self._T_base_laser = mount = scenario.lidar.mount.pose
        self._route_progress = RouteProgress(start, scenario.route.waypoints, scenario.route.arrival)
        runs = config.uses_slam or first.T_map_base is None
        self.slam: Estimator | None = make_estimator(scenario.slam, mount, start, seed) if runs else None
        self._views = make_views(config, scenario, extent)
        self._scan_time = scenario.lidar.description.lidar.scan_time
        self._began = first.scan.stamp
        seconds = min(scenario.duration, config.max_seconds or scenario.duration)
        self._last_turn = max(2, int(seconds / self._scan_time + 1e-9))
        self._no_more_scans = False
        self.moment = self.see(first)
        self.reward = make_reward(config, extent, self.moment)

    @property
    def turns(self) -> int:
        """Turns of the lidar since the robot was put down, the first scan's among them, lost scans too."""
        return 1 + round((self.moment.observation.scan.stamp - self._began) / self._scan_time)

    @property
    def seconds(self) -> float:
        """Time since the robot was put down."""
        return self.turns * self._scan_time

    @property
    def out_of_time(self) -> bool:
        """Whether this was the last scan for which there is time, or the robot has no more."""
        return self._no_more_scans or self.turns >= self._last_turn

    def run_out(self) -> None:
        """Take note that there are no more scans; the moment stays what it is."""
        self._no_more_scans = True

    def see(self, observation: Observation) -> StepState:
        """Take the next observation in: along the route, and through the method where it runs."""
        estimate = self.slam.update(observation.scan, observation.odometry) if self.slam else None
        T_map_base = observation.T_map_base
        if T_map_base is None:
            assert estimate is not None  # the method runs where the truth is not known
            T_map_base = estimate.T_map_base
        route = self._route_progress
        route.advance(T_map_base)
        T_map_laser = T_map_base @ self._T_base_laser
        self.moment = StepState(observation, T_map_base, T_map_laser, route.goal, route.arrived, route.left, estimate)
        return self.moment

    def views(self) -> dict[str, NDArray[Any]]:
        """What the agent sees of this moment, in fresh arrays."""
        return {name: view.of(self.moment) for name, view in self._views.items()}

    def reward_terms(self) -> dict[str, float]:
        """The parts that the reward of this moment is the sum of."""
        return {
            self.config.reward: self.reward.of(self.moment),
            "collision": -self.config.collision_penalty if self.moment.collided else 0.0,
        }
