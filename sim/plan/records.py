"""The robots and the settings of their scenarios, as records for compiled code. SI units, radians."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from sim.firmware import MOTOR_TORQUE, RECOVERY_TIME, STALL_TIME, WATCHDOG
from sim.wheels import WHEEL_RADIUS, TractionModel
from slam.scenario.robot_config import RobotConfig

AXLE_LOAD: Final = 67.0
"""N on both wheels: 9 kg less the 24 % that the caster carries, by the centre of mass of p3dx.urdf."""
BASE: Final = np.dtype(
    [
        ("x", "f8"), ("y", "f8"), ("theta", "f8"),  # T_map_base
        ("v", "f8"), ("omega", "f8"), ("target_v", "f8"), ("target_omega", "f8"),  # the setpoint and where it ramps to
        ("awake", "i8"),  # control steps until the watchdog stops the robot
        ("left", "f8"), ("right", "f8"),  # angles that the wheels without error have turned
        ("rim_left", "f8"), ("rim_right", "f8"),  # m/s over the floor
        ("ticks_left", "i8"), ("ticks_right", "i8"),  # at the last reading
        ("odom_x", "f8"), ("odom_y", "f8"), ("odom_theta", "f8"),  # T_odom_base
        ("way_left", "f8"), ("way_right", "f8"),  # metres rolled, as the odometry believes, since the last report
        ("in_vain", "i4"), ("in_order", "i4"), ("cut_for", "i4"),  # control steps: see sim/firmware.py, StallGuard
        ("stalled", "i4"), ("collided", "i4"), ("pressed", "i4"),  # since the last report; a bit for each segment
        ("stream", "u8"),  # of random numbers
    ],
    align=True,
)  # fmt: skip
"""One robot."""

MODEL: Final = np.dtype(
    [
        ("linear", "f8"), ("angular", "f8"), ("rise", "f8"), ("fall", "f8"), ("turn", "f8"),  # limits; a control step's
        ("left_radius", "f8"), ("right_radius", "f8"), ("track", "f8"), ("same", "f8"), ("other", "f8"),
        ("travel_noise", "f8"), ("encoder_noise", "f8"), ("spins", "i4"), ("firmware_units", "i4"),
        ("watchdog", "i4"), ("patience", "i4"), ("rest", "i4"), ("substeps", "i4"), ("substep", "f8"),
    ],
    align=True,
)  # fmt: skip
"""Settings of a scenario's robot; accelerations and times are per control step."""


def model_of(config: RobotConfig, physics_rate: int) -> NDArray[Any]:
    """Make the record, (1,), of this robot; the motors are simulated ``physics_rate`` times a second."""
    limits, believed, rate = config.limits, config.odometry, config.control_rate
    traction = TractionModel(config.traction)
    spins = config.traction.friction * AXLE_LOAD < 2.0 * MOTOR_TORQUE / WHEEL_RADIUS
    return np.array(
        [(
            limits.linear, limits.angular, limits.acceleration / rate, limits.deceleration / rate,
            limits.angular_acceleration / rate, believed.left_radius, believed.right_radius, believed.track,
            traction.same, traction.other, believed.travel_noise, believed.encoder_noise, spins,
            believed.firmware_units,
            round(WATCHDOG * rate), round(STALL_TIME * rate), round(RECOVERY_TIME * rate), physics_rate // rate,
            1.0 / physics_rate,
        )],
        MODEL,
    )  # fmt: skip
