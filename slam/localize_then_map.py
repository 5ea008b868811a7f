"""Mapping that goes on in a saved map, from a place that must be found first."""

from slam.config import SlamConfig
from slam.line_localizer import LineLocalizer
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.saved_slam import SavedSlam, relocate
from slam.scan import LaserScan


class LocalizeThenMap:
    """Localises until it is sure, then maps."""

    def __init__(self, config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam) -> None:
        self.T_base_laser, self._config, self._saved = T_base_laser, config, saved
        self.points = self.lines = saved.mapper.map
        self._localizer = LineLocalizer(config, T_base_laser, saved.mapper.map)
        self.slam: LineSlam | None = None
        """The mapping method, once the place is known."""

    @property
    def T_map_base(self) -> Pose2D:
        """The last estimate."""
        return (self.slam or self._localizer).T_map_base

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the pose estimate."""
        if self.slam is not None:
            return self.slam.update(scan, odometry)
        estimate = self._localizer.update(scan, odometry)
        if self._localizer.sure:
            self.slam = relocate(self._config, self.T_base_laser, self._saved, estimate.T_map_base)
            self.slam.T_odom_base = odometry.T_odom_base
        return estimate
