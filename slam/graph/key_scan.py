"""Key scans, from which the graph is made, each with the front end's data from its match."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slam.lidars import Lidar
from slam.pose import FloatArray, unit_vectors
from slam.scan import LaserScan

SILENT_SHARE, AGREEING_SHARE = 0.15, 0.6  # shares of agreeing facets at which the weight of a scan is 0 and 1


@dataclass(frozen=True, slots=True, eq=False)
class KeyScan:
    """A scan in the frame ``local``, in which odometry and matching to submaps place it; its pose there is final."""

    T_local_laser: FloatArray
    """(3,): pose of the sensor."""
    submaps: tuple[int, ...]
    """Numbers of the submaps to which the scan was added. It was matched to the first of them."""
    facets: FloatArray
    """(F, 7): short pieces of wall, sensor frame; the columns are those of ``slam.lines.facets``."""
    ranges: NDArray[np.float32]
    """(N,): ranges, metres, deskewed."""
    lidar: Lidar
    bearings: NDArray[np.float32] | None = None
    """(N,): bearings, radians, of a deskewed scan; None for those of the lidar."""
    information: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    """(3, 3): information of the match to the submap, in the axes of ``local``; 0 in directions that it does not
    constrain, and for a scan that was placed by odometry alone."""
    agreeing_share: float = 1.0
    """Share of its facets that agreed with the submap."""
    wheel_motion: FloatArray = field(default_factory=lambda: np.zeros(3))
    """(3,): motion since the previous key scan by the wheels alone, in the frame of that one."""
    index: int = 0
    """Index of the scan in the run."""
    broken: bool = False
    """True if the scan did not fit the ones before, so that only odometry connects them."""

    @property
    def scan(self) -> LaserScan:
        """The key scan as a LaserScan, with the fields that the map uses."""
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
        """Weight of its match to the submap, 0 to 1."""
        trust = (self.agreeing_share - SILENT_SHARE) / (AGREEING_SHARE - SILENT_SHARE)
        return 0.0 if self.broken else min(max(trust, 0.0), 1.0) ** 2

    @property
    def nbytes(self) -> int:
        """Memory of its arrays, bytes."""
        bearings = 0 if self.bearings is None else self.bearings.nbytes
        return self.facets.nbytes + self.ranges.nbytes + bearings + 3 * self.information.nbytes


def key_scan_fields(scan: LaserScan) -> tuple[NDArray[np.float32], Lidar, NDArray[np.float32] | None]:
    """Return ranges, lidar and bearings of a scan in the form of a key scan."""
    bearings = None if scan.beam_fan is None else scan.bearings.astype(np.float32)
    return scan.ranges.astype(np.float32), scan.lidar, bearings
