"""One turn of the user's lidar."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import Any, Final

import numpy as np

from hopslam.arguments import checked_angles, checked_lidar, checked_ranges, checked_stamp
from hopslam.beams import beams_of
from hopslam.segments import Segments
from hopslam.settings import slam_config
from slam.config import SlamConfig
from slam.errors import InputError
from slam.lines.extraction import extract_segments
from slam.lines.segments import IntArray
from slam.pose import FloatArray
from slam.scan import LaserScan

RANGE_MIN: Final = 0.02
"""Metres: many drivers write 0 for an erroneous reading."""


class Scan:
    """One turn of a planar lidar: ranges in metres at angles in radians, in the frame of the sensor.

    A range of ``inf`` means no echo, ``-inf`` too close and ``nan`` an erroneous reading (REP-117). A reading below
    ``range_min`` counts as erroneous, one above ``range_max`` as no echo. The angles may be uneven, clockwise or
    unsorted. ``stamp`` is the time of the first beam in seconds, ``time_increment`` the time between two beams, 0 if
    unknown; with a ``time_increment``, the angles must be in the order of measurement. InputError names the argument
    that is wrong.
    """

    def __init__(
        self,
        ranges: Any,
        angles: Any,
        stamp: float | None = None,
        *,
        range_min: float = RANGE_MIN,
        range_max: float = inf,
        time_increment: float = 0.0,
    ) -> None:
        measured = checked_ranges(ranges)
        bearings = checked_angles(angles, len(measured))
        near, far, between = checked_lidar(range_min, range_max, time_increment)
        measured[np.isfinite(measured) & (measured > far)] = inf
        beams = beams_of(bearings)
        self.stamp = None if stamp is None else checked_stamp(stamp)
        """Time of the first measured beam, seconds; None if the caller gave none."""
        first, between = _timing(beams.order, between)
        self._scan = LaserScan(
            first, beams.first, beams.step, near, far, measured[beams.order], between, beam_fan=beams.fan
        )

    @property
    def ranges(self) -> FloatArray:
        """Ranges, (N,), metres, counter-clockwise; must not be written to."""
        return _read_only(self._scan.ranges)

    @property
    def angles(self) -> FloatArray:
        """Bearings, (N,), radians, increasing; must not be written to."""
        return _read_only(self._scan.bearings)

    @property
    def points(self) -> FloatArray:
        """End points of the beams with an echo, (M, 2), metres, sensor frame."""
        return self._scan.points()

    def laser_scan(self, stamp: float = 0.0) -> LaserScan:
        """Convert to the scan of the package ``slam``, its first beam taken at ``stamp``.

        Not part of the stable API.
        """
        return replace(self._scan, stamp=stamp + self._scan.stamp)

    def segments(self, settings: str | Sequence[str] | SlamConfig = ()) -> Segments:
        """Extract the line segments of this scan with these settings; see ``Slam``."""
        found = extract_segments(self._scan, slam_config(settings).lines)
        return Segments(found, self.points)

    def __len__(self) -> int:
        return len(self._scan.ranges)

    def __repr__(self) -> str:
        angles, echoes = self.angles, int(self._scan.echoes.sum())
        return f"Scan({len(self)} beams from {angles[0]:.3f} to {angles[-1]:.3f} rad, {echoes} with an echo)"

    def picture(self) -> bytes:
        """Draw the points of the scan; return the content of a PNG file."""
        from slam.run.pictures.figure_style import png_of
        from slam.run.pictures.scan_picture import scan_figure

        return png_of(scan_figure(self.points, None, f"{len(self)} beams", inches=6.0))

    def _repr_png_(self) -> bytes:
        return self.picture()


def _timing(order: IntArray, between: float) -> tuple[float, float]:
    """Return the seconds from the first measured beam to the first in this order, and from each beam to the next.

    The second is negative for a lidar that turns clockwise.
    """
    if between == 0.0 or order[0] < order[-1] == len(order) - 1:
        return 0.0, between
    if order[0] != len(order) - 1 or order[-1] != 0:
        raise InputError("time_increment needs angles that only rise or only fall, and these do both; leave it out")
    return between * (len(order) - 1), -between


def _read_only(array: FloatArray) -> FloatArray:
    view = array.view()
    view.flags.writeable = False
    return view
