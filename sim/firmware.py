"""The parts of the base's firmware that move its motors: watchdog, speed ramps and stall protection.

The stall protection cuts motors that push in vain, and tries them again a little later. ARCOS has two settings for it,
which every P3-DX reports (Pioneer 3 Operations Manual, CONFIGpac): StallVal, "maximum
PWM before stall", and StallCount, milliseconds after a stall in which the motors are not engaged. The manual gives no
factory values, so the effort and both times are ours.
"""

from collections.abc import Sequence
from operator import or_
from typing import Final

from slam.compiled import compiled_on_views

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


class StallGuard:
    """Decides when the motors are cut; it is called in each of ``rate`` control steps per second."""

    def __init__(self, rate: int) -> None:
        self._patience = round(STALL_TIME * rate)
        self._rest = round(RECOVERY_TIME * rate)
        self._in_vain = self._in_order = self._cut_for = 0  # control steps
        self.stalled = False
        """True from the time the motors are cut until they have turned normally for STALL_TIME."""

    @property
    def engaged(self) -> bool:
        """True while the motors have power."""
        return self._cut_for == 0

    def watch(self, speeds: Sequence[float], torques: Sequence[float], limit: float) -> None:
        """Account for one control step that ended with these rim speeds, m/s, and torques.

        ``limit`` is the largest torque.
        """
        if not self.engaged:
            self._cut_for -= 1
            return
        in_vain = is_stalling(speeds, torques, limit)
        self._in_vain, self._in_order = (self._in_vain + 1, 0) if in_vain else (0, self._in_order + 1)
        if self._in_vain >= self._patience:
            self.stalled, self._in_vain, self._cut_for = True, 0, self._rest
        elif self._in_order >= self._patience:
            self.stalled = False


def is_stalling(speeds: Sequence[float], torques: Sequence[float], limit: float) -> bool:
    """Return True if a motor is at its limit and its wheel at rest, while no wheel turns freely.

    A wheel that turns freely swings the robot around the obstacle.
    """
    standing = [abs(speed) <= STANDING for speed in speeds]
    straining = [abs(torque) > 0.99 * limit for torque in torques]
    return any(straining) and any(standing) and all(map(or_, standing, straining))


@compiled_on_views
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
