"""The whole method on one page: Fig. 14."""

from dataclasses import dataclass
from time import perf_counter
from typing import Final

from slam.config import SlamConfig
from slam.deskew import deskewed
from slam.graph.closure import ClosedRun, Closure
from slam.graph.loop_closing import STEPPED, LoopClosing, Timing
from slam.lines.extraction import extract_segments
from slam.lines.learnt_noise import LearntNoise
from slam.lines.segments import Segments
from slam.mappers import make_mapper
from slam.matching.mapper import Lines, Mapper, Points
from slam.matching.match import NO_MATCH, Match
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

_ORIGIN: Final = Pose2D()


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The pose after one scan, and how it was found."""

    stamp: float
    T_map_base: Pose2D
    segments: Segments | None = None
    """Segments in the sensor frame; None if the scan was not used: the pose is then odometry since the last used."""
    match: Match = NO_MATCH
    map_points: int = 0
    """Size of the map after this scan: points in paper mode, surfels in this project's own."""
    extraction_time: float = 0.0
    """Seconds of wall time for the extraction of the segments."""
    total_time: float = 0.0
    """Seconds of wall time for the whole update."""
    T_map_local: Pose2D = _ORIGIN
    """Pose of the frame ``local`` of odometry and matching; it drifts, and jumps when a loop is closed."""
    closure: Closure | None = None
    """The closure that was applied at this scan: pose and map have changed as a whole."""
    back_end_lost: str = ""
    """Reason why the process that closes loops ended too early; empty while it runs, or without one."""

    @property
    def T_local_base(self) -> Pose2D:
        """Pose of odometry and matching, which closed loops do not change."""
        return self.T_map_local.inverse() @ self.T_map_base

    @property
    def mapped(self) -> bool:
        """True if the scan was matched and offered to the map."""
        return self.segments is not None

    @property
    def covariance(self) -> FloatArray | None:
        """Covariance (3, 3) of x, y, theta of ``T_map_base``, map frame, against the true pose; None in paper mode."""
        return self.match.covariance

    @property
    def unconstrained(self) -> FloatArray | None:
        """Directions (K, 3) that the scan did not constrain and odometry fixes, see Match; None in paper mode."""
        return self.match.unconstrained

    @property
    def lost(self) -> bool:
        """True if the last scans did not fit the map."""
        return self.match.lost

    @property
    def odometry_only(self) -> bool:
        """True if the pose is odometry alone since the last scan that was accepted."""
        return not self.mapped or self.match.odometry_only


class LineSlam:
    """Localisation by matching each scan to the map, and mapping."""

    def __init__(
        self,
        config: SlamConfig,
        T_base_laser: Pose2D,
        T_map_base: Pose2D | None = None,
        seed: int = 0,
        timing: Timing = STEPPED,
    ) -> None:
        self.config, self.timing = config, timing
        self.T_base_laser = T_base_laser
        self.T_local_base = T_map_base or Pose2D()  # the anchor: the true pose at the first scan (section 4)
        self.noise = LearntNoise.start(config.lines)  # learnt noise of the ranges
        self.mapper: Mapper = make_mapper(config, T_base_laser, seed)
        self.loops = LoopClosing.for_mapper(self.mapper, timing)
        self.scans = 0  # number of scans so far
        self.T_odom_base: Pose2D | None = None  # odometry at the last scan
        self.T_local_mapped: Pose2D | None = None  # T_local_base at the last scan that was matched

    @property
    def T_map_base(self) -> Pose2D:
        """Current estimate ``T_map_base``; with loops, the back end corrects it by the pose of the frame ``local``."""
        return self.T_map_local @ self.T_local_base if self.loops else self.T_local_base

    @property
    def T_map_local(self) -> Pose2D:
        """Pose in the map of the frame of odometry and matching."""
        return self.loops.T_map_local if self.loops else _ORIGIN

    @property
    def points(self) -> Points:
        """The map as points."""
        return self.loops.map if self.loops else self.mapper.points

    @property
    def lines(self) -> Lines:
        """The map as line segments."""
        return self.loops.map if self.loops else self.mapper.lines

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the new pose estimate. One turn of Fig. 14."""
        began = perf_counter()
        self.scans += 1
        prior = self._predict(odometry)  # eqs. (38)-(44)
        if not self._moved_enough(prior):
            self.T_local_base = prior
            return self._estimate(scan.stamp, began)
        if self.config.deskew:
            scan = deskewed(scan, odometry.twist, self.T_base_laser)
        segments = extract_segments(scan, self.config.lines, self.noise.observe(scan))  # eqs. (1)-(12), Proc. 1-8
        extraction_time = perf_counter() - began
        match = self.mapper.locate(scan, segments, prior)  # eqs. (20)-(37)
        T_local_laser = prior @ self.T_base_laser @ match.T_prior_laser  # eq. (19)
        self.mapper.add(scan, segments, T_local_laser)  # eqs. (15)-(18)
        self.T_local_base = self.T_local_mapped = T_local_laser @ self.T_base_laser.inverse()
        closure = self.loops.follow(self.scans - 1) if self.loops else None
        return self._estimate(scan.stamp, began, segments, match, extraction_time, closure)

    def finish(self) -> ClosedRun | None:
        """Close the last loops after the last scan, and refine the whole run; None if loops are not closed.

        BackEndLost if the process that closes them ended too early: the run then stays unchanged.
        """
        return self.loops.finish(self.T_base_laser) if self.loops else None

    def _estimate(
        self, stamp: float, began: float, segments: Segments | None = None, match: Match = NO_MATCH,
        extraction_time: float = 0.0, closure: Closure | None = None,
    ) -> Estimate:  # fmt: skip
        """Return the estimate in the map frame; time spent waiting for the back end does not count."""
        waited = self.loops.waited if self.loops and segments is not None else 0.0
        return Estimate(
            stamp, self.T_map_base, segments, match.turned(self.T_map_local.theta), len(self.points), extraction_time,
            perf_counter() - began - waited, self.T_map_local, closure, self.loops.back_end_lost if self.loops else "",
        )  # fmt: skip

    def _predict(self, odometry: Odometry) -> Pose2D:
        """Predict the pose of the base: moved by the odometry, or unchanged, as in eq. (20)."""
        last, self.T_odom_base = self.T_odom_base, odometry.T_odom_base
        if last is None or not self.config.odometry:
            return self.T_local_base
        return self.T_local_base @ last.between(odometry.T_odom_base)

    def _moved_enough(self, prior: Pose2D) -> bool:
        """Return True if the base has moved enough for a scan to be used.

        The paper uses each, like update_distance = 0.
        """
        if self.T_local_mapped is None:
            return True
        motion = self.T_local_mapped.between(prior)
        return motion.distance(Pose2D()) >= self.config.update_distance or abs(motion.theta) >= self.config.update_angle
