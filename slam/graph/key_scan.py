"""Key scans: those of which the graph is made, each with what the front end knew when it was matched."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slam.lidars import Lidar
from slam.pose import FloatArray, unit_vectors
from slam.scan import LaserScan

SILENT_SHARE, AGREEING_SHARE = 0.15, 0.6  # of the facets that agree: a scan says nothing below, all it claims above


@dataclass(frozen=True, slots=True, eq=False)
class KeyScan:
    """A scan in the frame ``local``, in which odometry and matching to submaps put it; it never moves there."""

    T_local_laser: FloatArray
    """(3,)."""
    submaps: tuple[int, ...]
    """Numbers of the submaps that it was written into; the first is the one that it was matched to."""
    facets: FloatArray
    """(F, 7), sensor frame."""
    ranges: NDArray[np.float32]
    """(N,) metres, deskewed."""
    lidar: Lidar
    bearings: NDArray[np.float32] | None = None
    """(N,) radians, of a scan that was deskewed; else they are those of the lidar."""
    information: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    """(3, 3) of T_local_laser against the submap, in the axes of ``local``; none for the first scan of a submap."""
    share: float = 1.0
    """Share of its facets that agreed with the submap."""
    wheels: FloatArray = field(default_factory=lambda: np.zeros(3))
    """(3,): the motion since the key scan before, by the wheels alone, in the frame of that one."""
    index: int = 0
    """Number of the scan in the run."""
    broken: bool = False
    """True where the scan did not fit what came before, so that odometry alone joins them."""

    @property
    def scan(self) -> LaserScan:
        """The scan, as far as the map needs it."""
        fan = None
        if self.bearings is not None:
            bearings = self.bearings.astype(np.float64)
            fan = np.ascontiguousarray(np.vstack([bearings, unit_vectors(bearings).T]))
        lidar = self.lidar
        return LaserScan(
            0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max,
            self.ranges.astype(np.float64), 0.0, lidar.scan_time, fan,
        )  # fmt: skip

    @property
    def trust(self) -> float:
        """Share of its information that its match to the submap deserves, 0 to 1."""
        trust = (self.share - SILENT_SHARE) / (AGREEING_SHARE - SILENT_SHARE)
        return 0.0 if self.broken else min(max(trust, 0.0), 1.0) ** 2

    @property
    def nbytes(self) -> int:
        """Memory of its arrays."""
        bearings = 0 if self.bearings is None else self.bearings.nbytes
        return self.facets.nbytes + self.ranges.nbytes + bearings + 3 * self.information.nbytes


def made_of(scan: LaserScan) -> tuple[NDArray[np.float32], Lidar, NDArray[np.float32] | None]:
    """Ranges, lidar and bearings of a scan as a key scan keeps them."""
    bearings = None if scan.beam_fan is None else scan.bearings.astype(np.float32)
    return scan.ranges.astype(np.float32), scan.lidar, bearings
