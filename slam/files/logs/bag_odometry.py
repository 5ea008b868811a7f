"""Odometry of a bag on the clock of its scans; faults are repaired or reported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slam.files.logs.bag_poses import PoseSeries
from slam.files.logs.odometry_resets import note_resets
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import Clock
from slam.files.ros.decoder import StampedOdometry
from slam.pose import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class BagOdometry:
    """Messages of odometry in the order of the bag; empty if it has none."""

    base: str
    """Name of the moving frame."""
    messages: Sequence[StampedOdometry]
    stamps: FloatArray
    """Stamps, seconds, shape (K,)."""
    received: FloatArray
    """Times of recording, seconds, shape (K,)."""

    @classmethod
    def of(cls, messages: Sequence[StampedOdometry], base: str) -> BagOdometry:
        """Return the odometry of the base in these messages."""
        stamps = np.array([message.odometry.stamp for message in messages])
        return cls(base, messages, stamps, np.array([message.received for message in messages]))

    def track(self, clock: Clock, stamps: FloatArray, statistics: ReadStatistics) -> PoseSeries | None:
        """Return the motion of the base on the clock of scans with these stamps, its resets joined.

        None if it is unknown. Repairs and gaps are noted.
        """
        if not self.messages:
            statistics.notes.append("no odometry in it")
            return None
        times, foreign = clock.times(self.stamps, self.received)
        if foreign:
            statistics.notes.append(
                f"{len(foreign)} of {len(times)} stamps of its odometry are of another clock than its scans; "
                "times of receipt are used"
            )
        messages = zip(self.messages, times.tolist(), strict=True)
        whole = PoseSeries.of_odometry([replace(message.odometry, stamp=time) for message, time in messages])
        track, joined = whole.joined()
        if joined.resets:
            note_resets(joined, (track.stamps - stamps[0]).tolist(), statistics)
        _note_holes(track, stamps, statistics)
        return track


def _note_holes(track: PoseSeries, stamps: FloatArray, statistics: ReadStatistics) -> None:
    """Note where the scans have no odometry; seconds count from the first scan."""
    if not track.covers(stamps):
        statistics.notes.append("its odometry does not cover the time of its scans")
    if holes := track.holes(stamps):
        (begin, end), count = holes[0], len(holes)
        statistics.notes.append(
            f"{count} gap{'s' * (count != 1)} in its odometry, {sum(b - a for a, b in holes):.1f} s in all, the first "
            f"at {begin - stamps[0]:.1f} to {end - stamps[0]:.1f} s"
        )
