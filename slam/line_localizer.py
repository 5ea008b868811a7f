"""Localisation in a saved map without a start pose: search, tracking, and search again when lost; or mapping there."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from slam.config import LeastSquaresConfig, SearchConfig, SlamConfig
from slam.deskew import deskewed
from slam.graph.loop_closing import STEPPED, Timing
from slam.line_slam import Estimate, LineSlam
from slam.lines.extraction import extract_segments
from slam.lines.facets import facets_of
from slam.lines.learnt_noise import LearntNoise
from slam.lines.segments import Segments
from slam.mapping.surfel_map import SurfelMap
from slam.matching.coarse_search import PLACE_X
from slam.matching.global_search import GlobalSearch
from slam.matching.match import NO_MATCH, Match
from slam.matching.pose_hypothesis import PoseHypothesis
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.saved_slam import SavedSlam, relocate
from slam.scan import LaserScan

NO_SEARCH = SearchConfig(below=0.0, distance=1e6, angle=1e6)
"""The coarse search switched off: many hypotheses replace it until the robot is sure."""


class LineLocalizer:
    """Localises in a map without changing it; it has the interface of LineSlam.

    It tracks many hypotheses at once, found by a search over the whole map, until the scans favour one. Then it is
    sure, and tracks only that one. If later scans contradict it, it is lost and searches again, keeping the hypotheses
    that it has: odometry links them to the new scans. ``Estimate.lost`` is True while it is not sure.
    """

    def __init__(
        self,
        config: SlamConfig,
        T_base_laser: Pose2D,
        surfel_map: SurfelMap,
        T_map_base: Pose2D | None = None,
        noise: LearntNoise | None = None,
    ) -> None:
        assert isinstance(config.matching, LeastSquaresConfig)
        self.config, self.T_base_laser = config, T_base_laser
        self.points = self.lines = surfel_map
        self.noise = noise or LearntNoise.start(config.lines)  # learnt noise of the ranges
        search = config.matching.search.model_copy(update={"anywhere": 0.0})  # GlobalSearch replaces it
        self._tracking = config.matching.model_copy(update={"search": search})
        self._without_search = config.matching.model_copy(update={"search": NO_SEARCH})
        self._search = GlobalSearch.of_map(surfel_map)
        self._hypotheses = [] if T_map_base is None else [self._hypothesis(T_map_base, self._tracking)]
        self.sure = T_map_base is not None
        """True while the pose of the robot is known."""
        self._given_pose: Pose2D | None = None  # T_map_base, given by the user, for the next scan
        self._T_odom_base: Pose2D | None = None
        self._moved = np.inf  # motion since the last evidence, metres plus radians; the first scan is evidence
        self._evidence_at: Pose2D | None = None  # T_map_base of the best hypothesis then
        self._evidence_count = 0  # pieces of evidence since the last search

    @property
    def T_map_base(self) -> Pose2D:
        """Pose of the best hypothesis; the origin if there is none yet."""
        return self._hypotheses[0].T_map_base if self._hypotheses else Pose2D()

    def place(self, T_map_base: Pose2D) -> None:
        """Set the pose at the next scan; it is taken as sure until the scans contradict it.

        Any thread may call this.
        """
        self._given_pose = T_map_base

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the pose estimate."""
        began = perf_counter()
        motion = self._motion(odometry)
        if self._given_pose is not None:
            given, self._given_pose = self._given_pose, None
            self._hypotheses, self.sure = [self._hypothesis(given, self._tracking)], True
            self._evidence_count, motion = 0, Pose2D()
        if self.config.deskew:
            scan = deskewed(scan, odometry.twist, self.T_base_laser)
        segments = extract_segments(scan, self.config.lines, self.noise.observe(scan))
        extraction_time = perf_counter() - began
        for hypothesis in self._hypotheses:
            hypothesis.follow(scan, segments, motion)
        if not self.config.odometry and self._evidence_at is not None:
            self._moved = _size(self._evidence_at.between(self.T_map_base))
        if self._moved >= self.config.localization.step:
            self._moved = 0.0
            self._take_evidence(scan, segments)
            self._evidence_at = self.T_map_base
        match, total_time = self._match(), perf_counter() - began
        return Estimate(scan.stamp, self.T_map_base, segments, match, len(self.points), extraction_time, total_time)

    def _match(self) -> Match:
        """Return the match of the best hypothesis; its covariance is against the map."""
        if not self._hypotheses:
            return replace(NO_MATCH, lost=True)
        best = self._hypotheses[0]
        return replace(best.match, covariance=best.covariance, lost=not self.sure)

    def _motion(self, odometry: Odometry) -> Pose2D:
        last, self._T_odom_base = self._T_odom_base, odometry.T_odom_base
        motion = Pose2D() if last is None or not self.config.odometry else last.between(odometry.T_odom_base)
        self._moved += _size(motion)
        return motion

    def _take_evidence(self, scan: LaserScan, segments: Segments) -> None:
        """Use the scan as evidence for and against the hypotheses; search if none is good."""
        config = self.config.localization
        self._evidence_count += 1
        for hypothesis in self._hypotheses:
            hypothesis.add_agreement(hypothesis.agreement(scan, config), config.memory)
        self._prune()
        good = bool(self._hypotheses) and self._hypotheses[0].mean_agreement >= config.doubt_below
        self.sure = good and (self.sure or self._decided())
        if not self._hypotheses or (not good and self._evidence_count >= config.search_every):
            self._search_map(scan, segments)
        elif self.sure and len(self._hypotheses) == 1:
            self._hypotheses[0].reconfigure(self._tracking)

    def _prune(self) -> None:
        """Sort the best first; drop those that have merged, and those far behind."""
        best_first = sorted(self._hypotheses, key=_most_evidence_first)
        self._hypotheses = []
        for hypothesis in best_first:
            behind = best_first[0].evidence - hypothesis.evidence
            if behind < self.config.localization.dropped_by and not any(map(hypothesis.same_place, self._hypotheses)):
                self._hypotheses.append(hypothesis)

    def _decided(self) -> bool:
        """Return True if the scans have decided for the first hypothesis."""
        config, (best, *others) = self.config.localization, self._hypotheses
        leads = not others or best.evidence - others[0].evidence >= config.sure_by
        return leads and best.mean_agreement >= config.sure_above and self._evidence_count >= config.sure_after

    def _search_map(self, scan: LaserScan, segments: Segments) -> None:
        """Add hypotheses from the whole map; existing ones stay."""
        config = self.config.localization
        self._evidence_count = 0
        facets = facets_of(scan, segments, self._tracking.facet_length)
        T_laser_base = self.T_base_laser.inverse()
        found: list[PoseHypothesis] = []
        for place in self._search.places(facets, config.places):
            hypothesis = self._hypothesis(Pose2D.from_array(place[PLACE_X:]) @ T_laser_base, self._without_search)
            hypothesis.follow(scan, segments, Pose2D())
            hypothesis.mean_agreement = hypothesis.evidence = hypothesis.agreement(scan, config)
            found.append(hypothesis)
        found.sort(key=_most_evidence_first)
        highest = found[0].evidence if found else 0.0
        for hypothesis in self._hypotheses:
            hypothesis.evidence = highest
        for hypothesis in found:
            room = len(self._hypotheses) < config.hypotheses
            if room and not any(map(hypothesis.same_place, self._hypotheses)):
                self._hypotheses.append(hypothesis)
        self._hypotheses.sort(key=_most_evidence_first)

    def _hypothesis(self, T_map_base: Pose2D, matching: LeastSquaresConfig) -> PoseHypothesis:
        return PoseHypothesis(self.points, matching, self.T_base_laser, T_map_base, self.config.odometry)


class LocalizeThenMap:
    """Localises in a saved map until it is sure, and then maps there."""

    def __init__(self, config: SlamConfig, T_base_laser: Pose2D, saved: SavedSlam, timing: Timing = STEPPED) -> None:
        self.T_base_laser, self._config, self._saved, self._timing = T_base_laser, config, saved, timing
        self._scans = 0  # number of scans before the pose was known
        self.points = self.lines = saved.mapper.map
        self._localizer = LineLocalizer(config, T_base_laser, saved.mapper.map, noise=saved.noise)
        self.slam: LineSlam | None = None
        """The mapping method, once the pose is known."""

    @property
    def T_map_base(self) -> Pose2D:
        """The last estimate."""
        return (self.slam or self._localizer).T_map_base

    def place(self, T_map_base: Pose2D) -> None:
        """Set the pose at the next scan; no effect once it maps."""
        self._localizer.place(T_map_base)

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        """Take the next scan and the odometry at its stamp; return the pose estimate."""
        if self.slam is not None:
            return self.slam.update(scan, odometry)
        estimate = self._localizer.update(scan, odometry)
        self._scans += 1
        if self._localizer.sure:
            place = estimate.T_map_base
            self.slam = relocate(self._config, self.T_base_laser, self._saved, place, self._timing)
            self.slam.T_odom_base, self.slam.scans = odometry.T_odom_base, self._scans
        return estimate


def _most_evidence_first(hypothesis: PoseHypothesis) -> float:
    return -hypothesis.evidence


def _size(motion: Pose2D) -> float:
    """Return the length of a motion, the sum of metres and radians."""
    return motion.distance(Pose2D()) + abs(motion.theta)
