"""The paper's matcher and map: map points are pulled onto the segments of the scan, and every scan is added."""

import numpy as np

from slam.config import ForceFieldConfig, PointMapConfig
from slam.lines.segments import Segments
from slam.mapping.line_map import LineMap
from slam.mapping.point_map import PointMap
from slam.matching.force_field import match_points_to_segments
from slam.matching.match import Match
from slam.pose import Pose2D
from slam.scan import LaserScan


class PaperMapper:
    """Mapper of the paper: sections 4.1 and 4.2."""

    def __init__(self, map_config: PointMapConfig, config: ForceFieldConfig, T_base_laser: Pose2D, seed: int) -> None:
        self.points = PointMap()
        self.lines = LineMap()
        self._map_config, self._config, self._T_base_laser = map_config, config, T_base_laser
        self._random = np.random.default_rng(seed)

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """Match by eqs. (20)-(37) from the pose of the base that odometry predicts."""
        T_map_laser = prior @ self._T_base_laser
        visible = self.points.draw_visible(T_map_laser, scan.lidar, self._map_config, self._random)  # eq. (20)
        return match_points_to_segments(visible, segments, self._config)  # eqs. (21)-(37)

    def add(self, scan: LaserScan, segments: Segments, T_map_laser: Pose2D) -> None:
        """Add all points and segments of the scan: eqs. (15)-(18)."""
        self.points.add(scan.points(), T_map_laser)
        self.lines.add(segments, T_map_laser)
