"""The front end of the graph: scans are matched to rolling submaps, and some of them become key scans.

A submap covers a path so short that its own error is small; loops connect it to older submaps. A new one begins after
every half of that length. Scans are matched to the oldest open map and added to all open ones; a map stays open after
its submap has ended, so that earlier walls are still in it when the robot turns a corner.
"""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig
from slam.graph.key_scan import KeyScan, key_scan_fields
from slam.graph.submap_uncertainty import SubmapUncertainty
from slam.lines.range_noise import RangeNoise
from slam.lines.segments import Segments
from slam.mapping.free_beams import free_beams
from slam.mapping.surfel_map import SurfelMap
from slam.matching.match import Match
from slam.matching.pose_search import Found
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.pose import FloatArray, Pose2D, wrap_angle
from slam.scan import LaserScan

LENGTH: Final = 8.0
"""Path length of a submap, metres; the next one begins half way."""
SUBMAPS, OPEN = 2, 3
"""Number of submaps that a key scan belongs to, and largest number of open maps."""
MIN_KEYS: Final = 10
"""Least number of key scans of a submap when the next one begins, whatever their distances."""
METRES_PER_RADIAN: Final = 0.3
"""Metres of path that a turn of one radian counts as."""
KEY_DISTANCE, KEY_ANGLE = 0.25, 0.25
"""A scan becomes a key scan after this much motion, metres, or this much turning, radians."""
MISFITS: Final = 2
"""Consecutive scans that contradict the map after which a new submap begins, connected by odometry alone. A single one
may come from wheels that reported late."""

RECOVERED_SHARE: Final = 0.5
"""Least share of agreeing facets of the next scan after a contradiction; below it, it contradicts the map as well."""


class SubmapMapper(SurfelMapper):
    """A SurfelMapper whose map is the oldest open one; ``key`` is the key scan that the last ``add`` made."""

    def __init__(
        self,
        state: SurfelMapperState,
        config: LeastSquaresConfig,
        T_base_laser: Pose2D,
        odometry: bool = True,
        number: int = 0,
    ) -> None:
        super().__init__(state, config, T_base_laser, odometry)
        self.key: KeyScan | None = None
        self.uncertainty = SubmapUncertainty(state.covariance)
        self._wheels = Pose2D()  # motion since the last key scan by odometry alone
        self.number = number
        """Number of the submap that began last."""
        self._open = [state.map]  # oldest first
        self._last_key: Pose2D | None = None
        self._path_length = 0.0  # metres
        self._began = 0.0  # path length at which the last submap began
        self._keys = 0  # number of key scans of the last submap
        self._misfits = 0  # consecutive scans that contradicted the map

    def locate(self, scan: LaserScan, segments: Segments, prior: Pose2D) -> Match:
        """See SurfelMapper; the motion to ``prior`` is kept for the next key scan."""
        if self.state.T_map_base is not None:
            self._wheels = self._wheels @ self.state.T_map_base.between(prior)
        return super().locate(scan, segments, prior)

    def add(self, scan: LaserScan, segments: Segments, T_local_laser: Pose2D) -> None:
        """Add the last located scan to the open submaps, if it was taken far enough from the last one."""
        self.key = None
        broken = self._is_broken()
        if broken:
            self._begin_anew()
        if not broken and self._found is not None and self._found.contradicted:
            return
        added = self.state.T_map_added
        motion = added.between(T_local_laser) if added else Pose2D()
        distance, turn = motion.distance(Pose2D()), abs(motion.theta)
        config = self.map.config
        if added is not None and not broken and distance < config.update_distance and turn < config.update_angle:
            return
        self._path_length += distance + METRES_PER_RADIAN * turn
        if self._is_key(T_local_laser, broken):
            if self._path_length - self._began >= 0.5 * LENGTH and self._keys >= MIN_KEYS:
                self._open_next()
            self._keys += 1
            self.key = self._key_scan(scan, T_local_laser, broken)
            self._last_key = T_local_laser
        self._write(scan, T_local_laser, distance + turn)

    def _find(
        self, scan: LaserScan, noise: RangeNoise | None, prior: Pose2D, predicted: FloatArray, last: Pose2D
    ) -> Found:
        """See SurfelMapper; after a misfit only a scan with a high agreement is accepted."""
        found = super()._find(scan, noise, prior, predicted, last)
        if self._misfits == 0 or found.fit.inliers >= RECOVERED_SHARE * len(self._facets):
            return found
        fit = found.fit._replace(pose=prior.as_array(), projector=np.zeros((3, 3)))
        return found._replace(fit=fit, odometry_only=True, odometry_failed=False, contradicted=True)

    def set_covariance(self, T_local_submap: FloatArray, covariance: FloatArray, T_map_local: Pose2D) -> None:
        """Set the covariance (3, 3) of a submap's pose after a loop was closed, map axes."""
        c, s = np.cos(T_map_local.theta), np.sin(T_map_local.theta)
        R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        self.uncertainty.set_covariance(Pose2D.from_array(T_local_submap), R @ covariance @ R.T)

    def _write(self, scan: LaserScan, T_local_laser: Pose2D, moved: float) -> None:
        self.state = self._with(T_map_added=T_local_laser)
        beams = free_beams(scan, self.map.config.no_echo_reach)
        for submap in self._open:
            submap.write(self._facets, beams, T_local_laser, moved, walls=False)
        self._walls.add_walls(T_local_laser.theta)

    def _is_key(self, T_local_laser: Pose2D, broken: bool) -> bool:
        last = self._last_key
        if last is None or broken:
            return True
        turn = abs(wrap_angle(T_local_laser.theta - last.theta))
        return last.distance(T_local_laser) >= KEY_DISTANCE or turn >= KEY_ANGLE

    def _is_broken(self) -> bool:
        """Return True if the last two scans did not fit, so that a new submap must begin."""
        contradicted = self._found is not None and self._found.contradicted
        self._misfits = self._misfits + 1 if contradicted else 0
        return self._misfits >= MISFITS or self._lost

    @property
    def _share(self) -> float:
        return 1.0 if self._found is None else self._found.fit.inliers / max(len(self._facets), 1)

    def _begin_anew(self) -> None:
        """Leave the mapped area: begin a submap that is connected by odometry alone."""
        self._misfits = 0
        self._open_next(most=1)
        self.state = self._with(bad_matches=0)

    def _open_next(self, most: int = OPEN) -> None:
        """Begin a submap; at most ``most`` maps stay open, and scans are matched to the oldest of them."""
        self.number, self._began, self._keys = self.number + 1, self._path_length, 0
        self._open = [*self._open, SurfelMap(self.map.config)][-most:]
        self.state = self._with(map=self._open[0])
        self.uncertainty.open_next(most)

    def _key_scan(self, scan: LaserScan, T_local_laser: Pose2D, broken: bool) -> KeyScan:
        ranges, lidar, bearings = key_scan_fields(scan)
        wheels, self._wheels = self.T_base_laser.inverse() @ self._wheels @ self.T_base_laser, Pose2D()
        submaps = tuple(range(self.number - min(len(self._open), SUBMAPS) + 1, self.number + 1))
        return KeyScan(
            T_local_laser.as_array(), submaps, self._facets, ranges, lidar, bearings,
            self._information(), self._share, wheels.as_array(), broken=broken,
        )  # fmt: skip

    def _information(self) -> FloatArray:
        """Return the information of the last match, in the directions that its scan constrained."""
        if self._found is None or self._found.odometry_only:
            return np.zeros((3, 3))
        fit, scale = self._found.fit, np.array([1.0, 1.0, self.config.lever])
        constrained = fit.projector * np.outer(1.0 / scale, scale)
        return np.asarray(constrained.T @ fit.information @ constrained)

    def _pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        return self.uncertainty.pose_covariance(pose, match_covariance)
