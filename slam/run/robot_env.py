"""Any ``Robot`` as a gymnasium environment, the interface through which runs step robots."""

import logging
from collections.abc import Callable
from math import inf
from typing import Any, Final

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from slam.errors import RobotError
from slam.files.ros.decimals import as_recorded
from slam.lidars import Lidar
from slam.odometry import Twist2D
from slam.robot import Observation, Robot
from slam.run.gym_arrays import odometry_array, odometry_space, scan_array, scan_space, twist_action

_LOG: Final = logging.getLogger("hopslam.run")
_MIN_STEP: Final = 1e-6
"""Resolution of the stamps of trajectories, seconds: files have microseconds."""
_MAX_LATE: Final = 50
"""Number of scans in a row without increasing stamps after which a robot is given up."""
Float32Array = NDArray[np.float32]
ObservationDict = dict[str, Float32Array]


class RobotEnv(gymnasium.Env[ObservationDict, Float32Array]):
    """A robot behind ``reset`` and ``step``; one step is one scan.

    Observations are ``scan`` (beams,), metres, with ``range_max`` for no echo and 0 for an echo that is too close, and
    ``odometry`` (5,): x, y, theta, linear and angular velocity. The fan is always that of ``lidar``: each beam is the
    nearest one of the measured scan. The action is (v, omega) in m/s and rad/s. Its space is limited to 1 of each, as
    learning algorithms need, but faster commands up to the limits of the robot are accepted. ``info`` has the whole
    ``Observation`` under ``observation`` and, after a step, the velocity that was ``applied``. The reward is 0.
    """

    def __init__(self, open_robot: Callable[[int], Robot], lidar: Lidar, limits: Twist2D) -> None:
        self._open_robot = open_robot
        self._lidar, self._limits = lidar, limits
        self._robot: Robot | None = None
        self._prepared: Robot | None = None
        self._last: ObservationDict = {}
        self._stamp = -inf
        self.observation_space = Dict(  # type: ignore[assignment]  # gymnasium types its Dict by Any
            scan=scan_space(lidar), odometry=odometry_space()
        )
        high = np.minimum(np.array([limits.linear, limits.angular], np.float32), np.float32(1.0))
        self.action_space = Box(-high, high, dtype=np.float32)

    @property
    def robot(self) -> Robot:
        """The robot of this episode; RobotError before the first reset and after close."""
        if self._robot is None:
            raise RobotError("the environment has no robot yet: call reset() first")
        return self._robot

    def wrapped(self, wrap: Callable[[Robot], Robot]) -> "RobotEnv":
        """Make an environment of the same robots, each in this wrapper."""
        return RobotEnv(lambda seed: wrap(self._open_robot(seed)), self._lidar, self._limits)

    def prepare(self, seed: int) -> None:
        """Make the robot of the next reset now, with its devices still closed; InputError if that fails."""
        self._prepared = self._open_robot(seed)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObservationDict, dict[str, Any]]:
        """Open a robot at its start, close the previous one, and wait for the first scan."""
        super().reset(seed=seed)
        self.close()
        robot, self._prepared = self._prepared, None
        if robot is None:
            robot = self._open_robot(int(self.np_random.integers(2**31)) if seed is None else seed)
        self._robot = robot.__enter__()
        self._stamp = -inf
        observation = self._observe()
        if observation is None:
            raise RobotError("the robot gave no scan at all")
        return self._as_dict(observation), {"observation": observation}

    def step(self, action: Float32Array) -> tuple[ObservationDict, float, bool, bool, dict[str, Any]]:
        """Drive at (v, omega) until the next scan; a collision terminates, the end of the scans truncates."""
        applied = self.robot.drive(twist_action(action))
        observation = self._observe()
        if observation is None:
            return {key: value.copy() for key, value in self._last.items()}, 0.0, False, True, {"applied": applied}
        info = {"observation": observation, "applied": applied}
        return self._as_dict(observation), 0.0, observation.collided, False, info

    def close(self) -> None:
        """Stop the robot and free its devices."""
        robot, self._robot = self._robot, None
        if robot is not None:
            robot.__exit__(None, None, None)

    def _observe(self) -> Observation | None:
        """Wait for a scan later than the last one; RobotError after too long a wait."""
        for _ in range(_MAX_LATE):
            observation = self.robot.observe()
            if observation is None:
                return None
            if observation.scan.stamp - self._stamp >= _MIN_STEP:
                self._stamp = observation.scan.stamp
                return as_recorded(observation)
            _LOG.warning(
                "a scan is left out: its stamp %.6f s is not later than %.6f s", observation.scan.stamp, self._stamp
            )
        raise RobotError(f"the stamps of {_MAX_LATE} scans in a row are not later than {self._stamp:.6f} s")

    def _as_dict(self, observation: Observation) -> ObservationDict:
        self._last = {
            "scan": scan_array(observation.scan, self._lidar),
            "odometry": odometry_array(observation.odometry),
        }
        return dict(self._last)
