"""One episode, scan by scan."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.env.config import EnvConfig
from slam.env.occupancy_grid import Extent
from slam.env.step_state import StepState
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.estimator import Estimator, make_estimator
from slam.run.pilots import RouteProgress
from slam.scenario.schema import Scenario


class Episode:
    """One episode; it begins with the first observation, at the pose ``start``.

    ``state`` is the state after the last observation. SLAM runs if the configuration needs it, or if the robot does not
    know its true pose.
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
        self._views = config.make_views(scenario, extent)
        self._scan_time = scenario.lidar.description.lidar.scan_time
        self._began = first.scan.stamp
        seconds = min(scenario.duration, config.max_seconds or scenario.duration)
        self._last_turn = max(2, int(seconds / self._scan_time + 1e-9))
        self._no_more_scans = False
        self.update(first)
        self._reward = config.make_reward(self.state, extent)

    @property
    def moment(self) -> StepState:
        """The state, under its name of version 0.1."""
        return self.state

    @property
    def turns(self) -> int:
        """Turns of the lidar since the episode began, including the first scan and lost scans."""
        return 1 + round((self.state.observation.scan.stamp - self._began) / self._scan_time)

    @property
    def seconds(self) -> float:
        """Time since the episode began."""
        return self.turns * self._scan_time

    @property
    def out_of_time(self) -> bool:
        """True if the episode has no time for another scan, or the robot has no more scans."""
        return self._no_more_scans or self.turns >= self._last_turn

    def update(self, observation: Observation | None) -> None:
        """Process the next observation: advance the route, and run SLAM if needed. None: no more scans."""
        if observation is None:
            self._no_more_scans = True
            return
        estimate = self.slam.update(observation.scan, observation.odometry) if self.slam else None
        T_map_base = observation.T_map_base
        if T_map_base is None:
            assert estimate is not None  # SLAM runs if the true pose is unknown
            T_map_base = estimate.T_map_base
        route = self._route_progress
        route.advance(T_map_base)
        T_map_laser = T_map_base @ self._T_base_laser
        self.state = StepState(
            observation, T_map_base, T_map_laser, route.goal, route.arrived, route.remaining, estimate
        )

    def views(self) -> dict[str, NDArray[Any]]:
        """Make the agent's views of this state, in new arrays."""
        return {name: view.of(self.state) for name, view in self._views.items()}

    def reward_terms(self) -> dict[str, float]:
        """Terms whose sum is the reward of the step to this state."""
        return {
            self.config.reward: self._reward(self.state),
            "collision": -self.config.collision_penalty if self.state.collided else 0.0,
        }

    def info(self, applied: Twist2D, terms: dict[str, float], ending: str) -> dict[str, Any]:
        """Make the ``info`` described in ``P3DXEnv``: plain numbers and new arrays, also for vector environments.

        Its keys depend on the arguments, not on the robot.
        """
        state = self.state
        info = {
            "observation": state.observation,
            "T_map_base": np.full(3, np.nan) if state.truth is None else state.truth.as_array(),
            "pose": state.T_map_base.as_array(),
            "pose_from": state.pose_source,
            "collided": state.observation.collided,
            "stalled": state.observation.stalled,
            "applied": np.array([applied.linear, applied.angular]),
            "stamp": state.observation.scan.stamp,
            "seconds": self.seconds,
            "route_left": state.route_left,
            "reward": dict(terms),
            "ending": ending,
        }
        if self.config.uses_slam and state.estimate is not None:
            covariance = state.estimate.covariance
            info |= {
                "slam_pose": state.estimated_pose.as_array(),
                "slam_covariance": np.full((3, 3), np.nan) if covariance is None else covariance.copy(),
                "slam_error": state.slam_error,
                "slam_lost": state.lost,
                "slam_odometry_only": state.estimate.odometry_only,
            }
        return info
