"""Dead reckoning from the reports of a P3-DX: it unwraps counters, drops impossible steps, and scales the wheels."""

from dataclasses import dataclass, replace
from math import hypot
from typing import Final

from hardware.arcos.encoder_packet import WheelTravel, travel_wrap
from hardware.arcos.model import ArcosUnits
from hardware.arcos.sip import Sip
from hardware.odometry_history import OdometryHistory
from slam.odometry import Twist2D
from slam.pose import Pose2D, wrap_angle

_SLACK: Final = Twist2D(0.02, 0.02)
"""Metres and radians by which a step may always differ from the wheels' speeds, for ramps and rounding."""
_SLACK_TIME: Final = 0.1
"""Seconds by which a report may be late: a step may also differ by the motion in this time."""
_SILENCE: Final = 0.3
"""Seconds without a report after which the base may have moved at any speed up to ``_FASTEST``."""
_FASTEST: Final = Twist2D(1.2, 5.3)
"""Top speeds of a P3-DX, m/s and rad/s."""
_PATIENCE: Final = 0.5
"""Seconds of impossible steps after which the odometry continues from the position that the robot reports."""


def unwrapped_step(before: float, after: float, wrap: float) -> float:
    """Return the smallest step between two readings of a counter modulo ``wrap``; within +-wrap / 2."""
    return (after - before + wrap / 2.0) % wrap - wrap / 2.0


@dataclass(frozen=True, slots=True)
class WheelScales:
    """Factors that ``hopslam calibrate`` finds, for the travel of both wheels and for the track width.

    ``half_track`` is half the track width that the robot assumes, metres.
    """

    half_track: float
    left: float = 1.0
    right: float = 1.0
    track: float = 1.0

    def corrected(self, motion: Twist2D) -> Twist2D:
        """Correct a reported speed, or a short distance and turn."""
        track = 2.0 * self.half_track
        left, right = motion.to_wheels(track)
        return Twist2D.from_wheels(self.left * left, self.right * right, track * self.track)


def sip_twist(sip: Sip, units: ArcosUnits) -> Twist2D:
    """Return the speed of the base."""
    twist = Twist2D.from_wheels(sip.left, sip.right, 2.0 * units.half_track)
    return twist if sip.turning is None else replace(twist, angular=sip.turning)


@dataclass(frozen=True, slots=True)
class _Reading:
    stamp: float
    sip: Sip
    twist: Twist2D
    pose: Pose2D = Pose2D()  # noqa: RUF009  # frozen


class PositionOdometry:
    """Integrates the position in each SIP.

    The checksum misses one damaged packet in many thousands, so a step that the speed of the wheels does not explain is
    left out. If a wrong step was accepted, the next report corrects it, as it fits the report before.
    """

    def __init__(self, units: ArcosUnits, scales: WheelScales, history: OdometryHistory) -> None:
        self._units = units
        self._scales = scales
        self._history = history
        self._believed: tuple[_Reading, ...] = ()
        """The last two reports, the newer one first."""
        self._first_refused: float | None = None

    def add(self, stamp: float, sip: Sip) -> bool:
        """Take a report, and return False if it is impossible."""
        reading = _Reading(stamp, sip, sip_twist(sip, self._units))
        if not self._believed:
            self._accept(reading, self._history.last[1] if self._history.last else Pose2D())
            return True
        for before in self._believed:
            step = self._step(before.sip, sip)
            if _plausible(step, before, reading):
                self._accept(reading, before.pose @ self._corrected(step))
                return True
        self._first_refused = self._first_refused or stamp
        if stamp - self._first_refused > _PATIENCE:
            self._believed = ()  # the robot's own position was set, or it restarted
        return False

    def _accept(self, reading: _Reading, pose: Pose2D) -> None:
        reading = replace(reading, pose=pose)
        self._believed, self._first_refused = (reading, *self._believed[:1]), None
        self._history.add(reading.stamp, pose, self._scales.corrected(reading.twist))

    def _step(self, before: Sip, after: Sip) -> Pose2D:
        wrap = self._units.wrap
        moved = Pose2D(unwrapped_step(before.x, after.x, wrap), unwrapped_step(before.y, after.y, wrap))
        turned = Pose2D(0.0, 0.0, before.theta).inverse() @ moved
        return Pose2D(turned.x, turned.y, wrap_angle(after.theta - before.theta))

    def _corrected(self, step: Pose2D) -> Pose2D:
        """Scale a step for each wheel, except the part that wheels cannot roll, such as rounding."""
        rolled = Twist2D.from_motion(step, 1.0)
        rest = rolled.motion(1.0).between(step)
        return self._scales.corrected(rolled).motion(1.0) @ rest


def _plausible(step: Pose2D, before: _Reading, after: _Reading) -> bool:
    seconds = after.stamp - before.stamp
    speed = (before.twist.linear + after.twist.linear) / 2.0
    turning = (before.twist.angular + after.twist.angular) / 2.0
    off = Twist2D(speed, turning).motion(seconds).between(step)
    fastest = max(abs(before.twist.linear), abs(after.twist.linear))
    fastest_turning = max(abs(before.twist.angular), abs(after.twist.angular))
    silence = max(0.0, seconds - _SILENCE)
    far = hypot(off.x, off.y) > _SLACK.linear + fastest * _SLACK_TIME + _FASTEST.linear * silence
    turn = _SLACK.angular + fastest_turning * _SLACK_TIME + _FASTEST.angular * silence
    return not far and abs(off.theta) <= turn


class EncoderOdometry:
    """Integrates the wheels' ticks, which come with each SIP and are finer than its position."""

    def __init__(self, ticks_per_metre: float, scales: WheelScales, history: OdometryHistory) -> None:
        self._wrap = travel_wrap(ticks_per_metre)
        self._scales = scales
        self._history = history
        self._last: WheelTravel | None = None

    def add(self, stamp: float, travel: WheelTravel, twist: Twist2D) -> None:
        """Take a reading, and the speed in the SIP before it."""
        pose = self._history.last[1] if self._history.last else Pose2D()
        if self._last is not None:
            left = unwrapped_step(self._last.left, travel.left, self._wrap)
            right = unwrapped_step(self._last.right, travel.right, self._wrap)
            rolled = Twist2D.from_wheels(left, right, 2.0 * self._scales.half_track)
            pose = pose @ self._scales.corrected(rolled).motion(1.0)
        self._last = travel
        self._history.add(stamp, pose, self._scales.corrected(twist))
