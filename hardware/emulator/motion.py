"""The part of the P3-DX's firmware that moves it: limits, ramps, watchdog, motors, emergency stop."""

from __future__ import annotations

from math import inf, radians
from typing import Final

from hardware.arcos.config_packet import ArcosConfig
from hardware.emulator.ramp import Ramp
from slam.odometry import Twist2D

_HARDEST_STOP: Final = 5.0
"""m/s^2, for E_STOP, the watchdog, and motors without power, which gears and brushes stop; and the turning ..."""
_HARDEST_TURN_STOP: Final = 20.0
"""... rad/s^2."""


class Motion:
    """Targets and what the motors make of them. ARCOS is said to take up its last target after the watchdog's stop."""

    def __init__(self, config: ArcosConfig) -> None:
        self._watchdog = config.watchdog or inf
        self._fed = -inf
        self._stopping_hard = False
        self.enabled = False
        self.e_stop = False
        self.starved = False
        """Whether the watchdog has run out."""
        self.linear = Ramp(config.max_linear, config.acceleration, config.deceleration)
        self.angular = Ramp(config.max_angular, config.angular_acceleration, config.angular_deceleration)

    @property
    def setpoint(self) -> Twist2D:
        """The speed of the motors."""
        return Twist2D(self.linear.speed, self.angular.speed)

    @property
    def moving(self) -> bool:
        """Whether the motors turn."""
        return self.setpoint != Twist2D()

    def feed(self, now: float) -> None:
        """A command came: the watchdog waits anew."""
        self._fed = now

    def enable(self, on: bool) -> None:
        """Power for the motors, unless the emergency stop is pressed; old targets are forgotten."""
        self.enabled = on and not self.e_stop
        self.ask(0.0, 0.0)

    def press(self, pressed: bool) -> None:
        """The emergency stop: it takes the power away, and does not give it back."""
        self.e_stop = pressed
        if pressed:
            self.enable(False)

    def ask(self, linear: float | None = None, angular: float | None = None) -> None:
        """New targets; ignored while a hard stop is going on."""
        if self._stopping_hard:
            return
        if linear is not None:
            self.linear.ask(linear)
        if angular is not None:
            self.angular.ask(angular)

    def go(self, metres: float) -> None:
        """MOVE: so far, at most at the limit, and stand; a negative way is backwards."""
        if not self._stopping_hard:
            self.linear.go(metres)

    def turn(self, radians: float) -> None:
        """DHEAD: the same of a turn to the left."""
        if not self._stopping_hard:
            self.angular.go(radians)

    def stop_hard(self) -> None:
        """E_STOP: stand as soon as the motors can."""
        self.ask(0.0, 0.0)
        self._stopping_hard = self.moving

    def advance(self, seconds: float, now: float) -> None:
        """One tick of the firmware."""
        self.starved = now - self._fed > self._watchdog
        free = self.enabled and not self.starved
        hard = self._stopping_hard or not free
        self.linear.approach(seconds, free, _HARDEST_STOP if hard else None)
        self.angular.approach(seconds, free, _HARDEST_TURN_STOP if hard else None)
        self._stopping_hard &= self.moving


FACTORY: Final = ArcosConfig(
    robot_type="Pioneer",
    subtype="p3dx-sh",
    serial_number="EMULATED",
    top_angular=radians(500),
    top_linear=2.2,
    top_angular_acceleration=radians(600),
    top_acceleration=4.0,
    pwm_max=500,
    name="emulated",
    sip_cycle=0.1,
    low_battery=11.5,
    rev_count=16570,
    watchdog=2.0,
    max_angular=radians(300),
    max_linear=1.2,
    angular_acceleration=radians(100),
    angular_deceleration=radians(100),
    acceleration=0.3,
    deceleration=0.6,
    front_bumpers=5,
    rear_bumpers=5,
    autobaud=2,
    ticks_per_metre=128_000,
    firmware="2.9",
)
"""What a P3-DX with an SH controller has in its FLASH."""
