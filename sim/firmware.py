"""The base's firmware, compiled: watchdog, speed ramps, motor speeds and stall protection.

``base`` is a record of the type BASE, ``model`` one of the type MODEL: sim/records.py.

The stall protection cuts motors that strain without turning, and tries them again a little later. ARCOS has two
settings for it, which every P3-DX reports (Pioneer 3 Operations Manual, CONFIGpac): StallVal, "maximum PWM before
stall", and StallCount, milliseconds after a stall in which the motors are not engaged. The manual gives no factory
values, so torque and both times are our choice.
"""

from typing import Any, Final

from slam.compiled import compiled_in_order

WATCHDOG: Final = 2.0
"""Seconds without a command after which ARCOS stops the robot (AMRISim, world.inc)."""
MOTOR_TORQUE: Final = 1.2
"""N m at a wheel, the most that the firmware allows; 25 N for both. The 9 kg robot needs 21 N for the 25 % slope of its
data sheet, and 5 N for its ramps. Tyres on a dry floor hold more than that (``Traction.friction``)."""
DRAG_TORQUE: Final = 0.3
"""N m with which the gears hold a wheel whose motor is cut. Our choice."""
STALL_TIME: Final = 0.3
"""Seconds at full torque with a wheel at rest after which the motors are cut."""
RECOVERY_TIME: Final = 0.3
"""Seconds for which the motors stay cut."""
STANDING: Final = 0.02
"""Rim speed up to which a wheel counts as at rest, m/s."""


@compiled_in_order
def switch_on(base: Any) -> None:
    """Stand still without a command, with nothing counted."""
    base.v = base.omega = base.target_v = base.target_omega = base.left = base.right = 0.0
    base.rim_left = base.rim_right = base.odom_x = base.odom_y = base.odom_theta = base.way_left = base.way_right = 0.0
    base.awake = base.ticks_left = base.ticks_right = 0
    base.in_vain = base.in_order = base.cut_for = base.stalled = 0


@compiled_in_order
def command(base: Any, model: Any, v: float, omega: float) -> tuple[float, float]:
    """Ask for a velocity; v and omega within the limits, to which the ramps now lead."""
    base.target_v = min(max(v, -model.linear), model.linear)
    base.target_omega = min(max(omega, -model.angular), model.angular)
    base.awake = model.watchdog
    return base.target_v, base.target_omega


@compiled_in_order
def control(base: Any, model: Any) -> bool:
    """Run one control step: watchdog and ramps; True where the setpoint changed."""
    if base.awake <= 0:
        base.target_v = base.target_omega = 0.0
    base.awake -= 1
    if base.cut_for > 0 or (base.v == base.target_v and base.omega == base.target_omega):
        return False
    base.v = ramped(base.v, base.target_v, model.rise, model.fall)
    base.omega = ramped(base.omega, base.target_omega, model.turn, model.turn)
    return True


@compiled_in_order
def set_velocity(base: Any, v: float, omega: float) -> bool:
    """Turn the wheels at this speed from now on, without ramps and watchdog; True where the setpoint changed."""
    if base.cut_for > 0 or (base.v == v and base.omega == omega):
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
    """Speeds of the simulated wheels, rad/s, when the firmware turns the robot's as it believes the setpoint needs."""
    rim = base.omega * model.track / 2.0
    left, right = (base.v - rim) / model.left_radius, (base.v + rim) / model.right_radius
    return model.same * left + model.other * right, model.other * left + model.same * right


@compiled_in_order
def is_stalling(left_speed: float, right_speed: float, left_torque: float, right_torque: float) -> bool:
    """Tell whether a motor strains at its limit and a wheel stands, while no wheel turns with ease.

    A wheel that turns with ease swings the robot around what it has met. Speeds of the rims, m/s; torques, N m.
    """
    left_stands, right_stands = abs(left_speed) <= STANDING, abs(right_speed) <= STANDING
    left_strains, right_strains = abs(left_torque) > 0.99 * MOTOR_TORQUE, abs(right_torque) > 0.99 * MOTOR_TORQUE
    if not (left_stands or left_strains) or not (right_stands or right_strains):
        return False
    return (left_strains or right_strains) and (left_stands or right_stands)


@compiled_in_order
def watch(base: Any, model: Any, in_vain: bool) -> bool:
    """Account for one control step in which the motors pushed ``in_vain`` or not.

    True where they were cut just now, or have power again; the ramps then begin at rest. They are cut while ``cut_for``
    is not 0, and ``stalled`` stays until they have worked in order for STALL_TIME.
    """
    if base.cut_for > 0:
        base.cut_for -= 1
        if base.cut_for > 0:
            return False
    else:
        base.in_vain, base.in_order = (base.in_vain + 1, 0) if in_vain else (0, base.in_order + 1)
        if base.in_vain < model.patience:
            if base.in_order >= model.patience:
                base.stalled = 0
            return False
        base.stalled, base.in_vain, base.cut_for = 1, 0, model.rest
    base.v = base.omega = 0.0
    return True
