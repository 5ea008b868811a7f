"""Packets of a turning lidar, gathered to turns, and a turn as a scan."""

from dataclasses import dataclass
from math import pi

import numpy as np

from hardware.ldrobot import POINTS, LdPacket
from slam.pose import FloatArray
from slam.scan import LaserScan

_TURN = 2.0 * pi


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """Points of one clockwise turn that begins behind the robot; radians, metres, seconds of the host."""

    angles: FloatArray
    """(N,): bearings, clockwise from ahead, increasing from pi to 3 pi."""
    ranges: FloatArray
    """(N,): ranges; inf without an echo."""
    times: FloatArray
    """(N,): times."""

    def scan(self, range_min: float, range_max: float) -> LaserScan:
        """Return the scan, counter-clockwise and evenly spaced, nan where points are missing.

        The sensor measures at a fixed rate while its motor is held at a speed, so that its points are even within a
        turn; packets that were lost leave gaps. The last point is the first beam, and has the stamp.
        """
        step = float(np.median(np.diff(self.angles)))
        places = np.round((self.angles[-1] - self.angles) / step).astype(int)
        first, slope = np.polynomial.polynomial.polyfit(places, self.angles, 1)
        ranges = np.full(places[0] + 1, np.nan)
        ranges[places] = self.ranges
        between = float(self.times[-1] - self.times[0]) / max(int(places[0]), 1)
        with np.errstate(invalid="ignore"):
            ranges = np.where(ranges < range_min, -np.inf, np.where(ranges > range_max, np.inf, ranges))
        return LaserScan(
            stamp=float(self.times[-1]),
            angle_min=float(_TURN - first),
            angle_increment=float(-slope),
            range_min=range_min,
            range_max=range_max,
            ranges=ranges,
            time_increment=-between,
            scan_time=between * _TURN / -float(slope),
        )


class TurnCollector:
    """Gathers points until a turn is complete: the angle passes behind the robot."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float, float]] | None = None
        """Angle from pi to 3 pi, range, time; None before the first turn begins."""
        self._angle = 0.0

    def add(self, packet: LdPacket, last_at: float) -> Turn | None:
        """Take a packet whose last point was measured at ``last_at``; return the turn that it completes, if any."""
        whole = None
        times = last_at - (packet.last - packet.angles) / packet.speed
        for angle, metres, at in zip(
            (packet.angles % _TURN).tolist(), packet.ranges.tolist(), times.tolist(), strict=True
        ):
            if self._angle < pi <= angle:
                whole, self._points = self._whole(), []
            self._angle = angle
            self._append(angle if angle >= pi else angle + _TURN, metres, at)
        return whole

    def _append(self, angle: float, metres: float, at: float) -> None:
        if self._points and angle <= self._points[-1][0]:  # more than half a turn was lost
            self._points = None
        if self._points is not None:
            self._points.append((angle, metres, at))

    def _whole(self) -> Turn | None:
        if not self._points or len(self._points) < POINTS:
            return None
        return Turn(*np.array(self._points).T)
