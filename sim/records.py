"""The robots and the settings of their scenarios, as records for compiled code. SI units, radians."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from sim.firmware import MOTOR_TORQUE, RECOVERY_TIME, STALL_TIME, WATCHDOG
from sim.wheels import TRACK, WHEEL_RADIUS
from slam.scenario.robot_config import RobotConfig

AXLE_LOAD: Final = 67.0
"""Load on both wheels, N: 9 kg less the 24 % that the caster carries, by the centre of mass of p3dx.urdf."""
BASE: Final = np.dtype(
    [
        ("v", "f8"), ("omega", "f8"),  # the setpoint
        ("target_v", "f8"), ("target_omega", "f8"),  # the target of its ramps
        ("watchdog_steps", "i8"),  # control steps until the watchdog stops the robot
        ("left", "f8"), ("right", "f8"),  # angles that the simulated wheels have turned
        ("rim_left", "f8"), ("rim_right", "f8"),  # their speeds, m/s over the floor
        ("ticks_left", "i8"), ("ticks_right", "i8"),  # at the last reading
        ("odom_x", "f8"), ("odom_y", "f8"), ("odom_theta", "f8"),  # T_odom_base
        ("travel_left", "f8"), ("travel_right", "f8"),  # measured wheel travel since the last report, metres
        # Counters and state of the stall protection, see sim.firmware.update_stall_protection:
        ("straining_steps", "i4"), ("working_steps", "i4"), ("off_steps", "i4"), ("stalled", "i4"),
        # Only the kinematic model uses the rest: PyBullet keeps the true state itself.
        ("x", "f8"), ("y", "f8"), ("theta", "f8"),  # T_map_base
        ("collided", "i4"), ("bumpers", "i4"),  # since the last report; one bit per bumper segment
        ("stream", "u8"),  # state of the random number generator
    ],
    align=True,
)  # fmt: skip
"""One robot."""

MODEL: Final = np.dtype(
    [
        ("linear", "f8"), ("angular", "f8"),  # limits of the speed
        ("acceleration", "f8"), ("deceleration", "f8"), ("angular_acceleration", "f8"),  # per control step
        ("left_radius", "f8"), ("right_radius", "f8"), ("track", "f8"),  # as set in the firmware
        # Slip and scrub:
        ("own_gain", "f8"), ("cross_gain", "f8"), ("own_gain_inverse", "f8"), ("cross_gain_inverse", "f8"),
        ("travel_noise", "f8"), ("encoder_noise", "f8"), ("wheels_spin", "i4"), ("firmware_units", "i4"),
        ("watchdog", "i4"), ("stall_steps", "i4"), ("recovery_steps", "i4"), ("substeps", "i4"), ("substep", "f8"),
    ],
    align=True,
)  # fmt: skip
"""Settings of a scenario's robot; accelerations and times are per control step."""

ROBOT: Final = np.dtype([("base", BASE), ("model", MODEL), ("noise", "f8", 4), ("motors", "f8", 3)], align=True)
"""All data of ``sim.controller.Controller`` in one record, which Python passes faster than four. The properties of that
class describe ``noise`` and ``motors``."""


def model_of(config: RobotConfig, physics_rate: int) -> NDArray[Any]:
    """Make the record, (1,), of this robot; the motors are simulated ``physics_rate`` times a second.

    The motors turn the robot's wheels, and the encoders count them. Slip and scrub scale their motion before it reaches
    the simulated wheels, which have no error. With slip s and scrub k = TRACK / effective_track, the simulated
    wheels have (1 - s) times the mean motion of the robot's wheels, and (1 - s) k times their difference: a simulated
    wheel turns by ``own_gain`` times the motion of its own wheel plus ``cross_gain`` times that of the other. The
    inverse matrix has the entries ``own_gain_inverse`` and ``-cross_gain_inverse``.
    """
    limits, believed, traction, rate = config.limits, config.odometry, config.traction, config.control_rate
    kept, scrub = 1.0 - traction.slip, TRACK / traction.effective_track
    own_gain, cross_gain, det = kept * (1.0 + scrub) / 2.0, kept * (1.0 - scrub) / 2.0, kept * kept * scrub
    spins = traction.friction * AXLE_LOAD < 2.0 * MOTOR_TORQUE / WHEEL_RADIUS
    return np.array(
        [(
            limits.linear, limits.angular, limits.acceleration / rate, limits.deceleration / rate,
            limits.angular_acceleration / rate, believed.left_radius, believed.right_radius, believed.track,
            own_gain, cross_gain, own_gain / det, cross_gain / det, believed.travel_noise, believed.encoder_noise,
            spins, believed.firmware_units,
            round(WATCHDOG * rate), round(STALL_TIME * rate), round(RECOVERY_TIME * rate), physics_rate // rate,
            1.0 / physics_rate,
        )],
        MODEL,
    )  # fmt: skip
