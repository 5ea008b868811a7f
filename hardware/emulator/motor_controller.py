"""The part of the P3-DX's firmware that moves it: limits, ramps, watchdog, motors, emergency stop."""

from dataclasses import dataclass
from math import copysign, inf, sqrt
from typing import Final

from hardware.arcos.config_packet import ArcosConfig
from slam.odometry import Twist2D

_HARDEST_STOP: Final = 5.0
"""Deceleration, m/s^2, of E_STOP, the watchdog, and motors without power, stopped by gears and brushes."""
_HARDEST_TURN_STOP: Final = 20.0
"""The same for turning, rad/s^2."""


@dataclass(slots=True)
class Ramp:
    """One speed, its limit, and its ramps towards a target: another speed, or a distance; SI units."""

    limit: float
    top: float
    """Largest limit that can be set."""
    rise: float
    fall: float
    target: float = 0.0
    speed: float = 0.0
    left: float | None = None
    """Remaining distance; None if the target is a speed."""

    def set_target(self, speed: float) -> None:
        """Set the target speed, within the limit; a remaining distance is forgotten."""
        self.target, self.left = max(-self.limit, min(self.limit, speed)), None

    def set_limit(self, speed: float) -> None:
        """Set the limit from its absolute value: SETV and SETRV."""
        self.limit = min(abs(speed), self.top)

    def set_slope(self, rate: float) -> None:
        """Set the acceleration if positive, the deceleration if negative: SETA and SETRA."""
        if rate > 0.0:
            self.rise = rate
        elif rate < 0.0:
            self.fall = -rate

    def approach(self, seconds: float, free: bool, hardest: float | None) -> None:
        """Change the speed towards the target, or towards 0 if not ``free``; a reversal stops at zero first.

        ``hardest`` is the deceleration of an emergency stop.
        """
        target = (self.target if self.left is None else self._towards_end(seconds)) if free else 0.0
        if self.speed * target < 0.0:
            target = 0.0
        rate = hardest or (self.rise if abs(target) > abs(self.speed) else self.fall)
        step = rate * seconds
        self.speed += max(-step, min(step, target - self.speed))
        if self.left is not None:
            self.left -= self.speed * seconds

    def _towards_end(self, seconds: float) -> float:
        """Return the speed from which the remaining distance suffices to stop.

        Near the end it is the speed that covers the rest in one step.
        """
        left = self.left or 0.0
        fastest = min(self.limit, sqrt(2.0 * self.fall * abs(left)), abs(left) / seconds)
        return copysign(fastest, left)


class MotorController:
    """Target speeds, and the speeds of the motors, which approach them.

    ARCOS is said to resume its last target after the watchdog has stopped it, and so does this controller.
    """

    def __init__(self, config: ArcosConfig) -> None:
        self._watchdog = config.watchdog or inf
        self._fed_at = -inf
        self._stopping_hard = False
        self.enabled = False
        self.e_stop = False
        self.watchdog_expired = False
        self.linear = Ramp(config.max_linear, config.top_linear, config.acceleration, config.deceleration)
        self.angular = Ramp(
            config.max_angular, config.top_angular, config.angular_acceleration, config.angular_deceleration
        )

    @property
    def setpoint(self) -> Twist2D:
        """Speed of the motors."""
        return Twist2D(self.linear.speed, self.angular.speed)

    @property
    def moving(self) -> bool:
        """True while the motors turn."""
        return self.setpoint != Twist2D()

    def feed_watchdog(self, now: float) -> None:
        """Restart the watchdog, as a command came."""
        self._fed_at = now

    def enable(self, on: bool) -> None:
        """Switch the motors' power, unless the emergency stop is pressed; earlier targets are forgotten."""
        self.enabled = on and not self.e_stop
        self.set_targets(0.0, 0.0)

    def press_e_stop(self, pressed: bool) -> None:
        """Press the emergency stop, which cuts the power, or release it, which does not restore the power."""
        self.e_stop = pressed
        if pressed:
            self.enable(False)

    def set_targets(self, linear: float | None = None, angular: float | None = None) -> None:
        """Set new target speeds; ignored during an emergency stop."""
        if self._stopping_hard:
            return
        if linear is not None:
            self.linear.set_target(linear)
        if angular is not None:
            self.angular.set_target(angular)

    def move_by(self, metres: float) -> None:
        """Move by this distance, at most at the limit, and stop (MOVE); negative is backwards."""
        if not self._stopping_hard:
            self.linear.left = metres

    def turn_by(self, radians: float) -> None:
        """Turn by this angle, at most at the limit, and stop (DHEAD); positive is to the left."""
        if not self._stopping_hard:
            self.angular.left = radians

    def stop_hard(self) -> None:
        """Stop as fast as the motors can: E_STOP."""
        self.set_targets(0.0, 0.0)
        self._stopping_hard = self.moving

    def advance(self, seconds: float, now: float) -> None:
        """Do one tick of the firmware."""
        self.watchdog_expired = now - self._fed_at > self._watchdog
        free = self.enabled and not self.watchdog_expired
        hard = self._stopping_hard or not free
        self.linear.approach(seconds, free, _HARDEST_STOP if hard else None)
        self.angular.approach(seconds, free, _HARDEST_TURN_STOP if hard else None)
        self._stopping_hard &= self.moving
