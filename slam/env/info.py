"""What goes into ``info``: plain numbers and fresh arrays, which vector environments can put together."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.env.episode import Episode
from slam.line_slam import Estimate
from slam.odometry import Twist2D
from slam.pose import FloatArray


def episode_info(episode: Episode, applied: Twist2D, parts: dict[str, float], ending: str) -> dict[str, Any]:
    """The table of the manual of ``P3DXEnv``; which keys there are depends on the arguments, not on the robot."""
    moment = episode.moment
    info = {
        "observation": moment.observation,
        "T_map_base": np.full(3, np.nan) if moment.truth is None else moment.truth.as_array(),
        "pose": moment.T_map_base.as_array(),
        "pose_from": moment.source,
        "collided": moment.observation.collided,
        "stalled": moment.observation.stalled,
        "applied": np.array([applied.linear, applied.angular]),
        "stamp": moment.observation.scan.stamp,
        "seconds": episode.seconds,
        "route_left": moment.left,
        "reward": dict(parts),
        "ending": ending,
    }
    if episode.config.uses_slam and moment.estimate is not None:
        info |= {
            "slam_pose": moment.belief.as_array(),
            "slam_covariance": _covariance(moment.estimate),
            "slam_error": moment.slam_error,
            "slam_lost": moment.lost,
        }
    return info


def _covariance(estimate: Estimate) -> FloatArray:
    return np.full((3, 3), np.nan) if estimate.covariance is None else estimate.covariance.copy()
