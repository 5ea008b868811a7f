"""Reports of the kinematic robot's firmware: odometry in the units of ARCOS."""

from typing import Any

import numpy as np

from sim.wheels import ANGLE_UNIT, MILLIMETRE
from slam.compiled import compiled_on_views


@compiled_on_views
def reported_pose(base: Any, model: Any) -> tuple[float, float, float]:
    """``T_odom_base``: x, y, theta."""
    if not model.firmware_units:
        return base.odom_x, base.odom_y, base.odom_theta
    return (
        np.rint(base.odom_x / MILLIMETRE) * MILLIMETRE,
        np.rint(base.odom_y / MILLIMETRE) * MILLIMETRE,
        np.rint(base.odom_theta / ANGLE_UNIT) * ANGLE_UNIT,
    )


@compiled_on_views
def take_mean_twist(base: Any, model: Any, seconds: float) -> tuple[float, float]:
    """Return the mean v and omega since the last call, ``seconds`` ago; 0 if no time passed."""
    rate = 1.0 / seconds if seconds > 0.0 else 0.0
    left, right = base.way_left * rate, base.way_right * rate
    base.way_left = base.way_right = 0.0
    if model.firmware_units:
        left, right = np.rint(left / MILLIMETRE) * MILLIMETRE, np.rint(right / MILLIMETRE) * MILLIMETRE
    return 0.5 * (left + right), (right - left) / model.track
