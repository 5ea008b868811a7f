"""The base's firmware, compiled: watchdog, speed ramps, motor speeds and stall protection.

``base`` is a record of the type BASE, ``model`` one of the type MODEL: sim/records.py.

The stall protection switches off motors that strain without turning, and switches them on again a little later.
ARCOS has two settings for it, which every P3-DX reports (Pioneer 3 Operations Manual, CONFIGpac): StallVal, "maximum
PWM before stall", and StallCount, milliseconds after a stall in which the motors are not engaged. The manual gives no
factory values, so torque and both times are our choice.
"""

from typing import Any, Final

from slam.compiled import compiled_in_order

WATCHDOG: Final = 2.0
"""Seconds without a command after which ARCOS stops the robot (AMRISim, world.inc)."""
MOTOR_TORQUE: Final = 1.2
"""Largest torque at a wheel that the firmware allows, N m; 25 N for both wheels.

The 9 kg robot needs 21 N for the 25 % slope of its data sheet, and 5 N for its ramps. Tyres on a dry floor hold more
than that (``Traction.friction``).
"""
DRAG_TORQUE: Final = 0.3
"""Torque with which the gears hold a wheel whose motor is off, N m. Our choice."""
STALL_TIME: Final = 0.3
"""Seconds at full torque with a wheel at rest after which the motors are switched off."""
RECOVERY_TIME: Final = 0.3
"""Seconds for which the motors stay off."""
STANDING: Final = 0.02
"""Rim speed up to which a wheel counts as at rest, m/s."""


@compiled_in_order
def switch_on(base: Any) -> None:
    """Reset the record: the robot stands at the origin without a command."""
    base.v = base.omega = base.target_v = base.target_omega = base.left = base.right = 0.0
    base.rim_left = base.rim_right = base.odom_x = base.odom_y = base.odom_theta = base.travel_left = (
        base.travel_right
    ) = 0.0
    base.watchdog_steps = base.ticks_left = base.ticks_right = 0
    base.straining_steps = base.working_steps = base.off_steps = base.stalled = 0


@compiled_in_order
def command(base: Any, model: Any, v: float, omega: float) -> tuple[float, float]:
    """Set the target of the ramps, and return it: v and omega within the limits."""
    base.target_v = min(max(v, -model.linear), model.linear)
    base.target_omega = min(max(omega, -model.angular), model.angular)
    base.watchdog_steps = model.watchdog
    return base.target_v, base.target_omega


@compiled_in_order
def control(base: Any, model: Any) -> bool:
    """Run the watchdog and the ramps for one control step; return True if the setpoint changed."""
    if base.watchdog_steps <= 0:
        base.target_v = base.target_omega = 0.0
    base.watchdog_steps -= 1
    if base.off_steps > 0 or (base.v == base.target_v and base.omega == base.target_omega):
        return False
    base.v = ramped(base.v, base.target_v, model.acceleration, model.deceleration)
    base.omega = ramped(base.omega, base.target_omega, model.angular_acceleration, model.angular_acceleration)
    return True


@compiled_in_order
def set_velocity(base: Any, v: float, omega: float) -> bool:
    """Set the setpoint without ramps and watchdog; return True if it changed."""
    if base.off_steps > 0 or (base.v == v and base.omega == omega):
        return False
    base.v, base.omega = v, omega
    return True


@compiled_in_order
def ramped(speed: float, target: float, rise: float, fall: float) -> float:
    """Return the speed one control step later: it grows by at most ``rise`` and shrinks by at most ``fall``.

    A reversal passes through zero: the speed falls first and rises afterwards.
    """
    if speed * target < 0.0:
        target = 0.0
    largest = rise if abs(target) > abs(speed) else fall
    if abs(target - speed) <= largest:
        return target
    return speed + largest if target > speed else speed - largest


@compiled_in_order
def wheel_speeds(base: Any, model: Any) -> tuple[float, float]:
    """Return the speeds of the simulated wheels, rad/s, for the setpoint and the firmware's wheel radii and track."""
    rim = base.omega * model.track / 2.0
    left, right = (base.v - rim) / model.left_radius, (base.v + rim) / model.right_radius
    return model.own_gain * left + model.cross_gain * right, model.cross_gain * left + model.own_gain * right


@compiled_in_order
def is_stalling(left_speed: float, right_speed: float, left_torque: float, right_torque: float) -> bool:
    """Return True if a motor strains at its limit and a wheel stands, while no wheel turns easily.

    A wheel that turns easily swings the robot around the obstacle. Speeds of the rims, m/s; torques, N m.
    """
    left_stands, right_stands = abs(left_speed) <= STANDING, abs(right_speed) <= STANDING
    left_strains, right_strains = abs(left_torque) > 0.99 * MOTOR_TORQUE, abs(right_torque) > 0.99 * MOTOR_TORQUE
    if not (left_stands or left_strains) or not (right_stands or right_strains):
        return False
    return (left_strains or right_strains) and (left_stands or right_stands)


@compiled_in_order
def update_stall_protection(base: Any, model: Any, straining: bool) -> bool:
    """Count one control step for the stall protection; ``straining`` is the result of ``is_stalling``.

    Return True if the motors were switched off or on again; the ramps then start at rest. They are off while
    ``off_steps`` is not 0, and ``stalled`` stays set until they have worked without straining for STALL_TIME.
    """
    if base.off_steps > 0:
        base.off_steps -= 1
        if base.off_steps > 0:
            return False
    else:
        base.straining_steps, base.working_steps = (
            (base.straining_steps + 1, 0) if straining else (0, base.working_steps + 1)
        )
        if base.straining_steps < model.stall_steps:
            if base.working_steps >= model.stall_steps:
                base.stalled = 0
            return False
        base.stalled, base.straining_steps, base.off_steps = 1, 0, model.recovery_steps
    base.v = base.omega = 0.0
    return True
