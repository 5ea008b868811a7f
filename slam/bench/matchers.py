"""Compared matchers: each is built from the scans of the map, then estimates where a scan was taken."""

from collections.abc import Sequence
from typing import Any, Final, Protocol

import numpy as np

from slam.bench.match_scenes import PlacedScan
from slam.config import ForceFieldConfig, HoppingConfig, LeastSquaresConfig, PointMapConfig, SlamConfig, SurfelMapConfig
from slam.line_localizer import NO_SEARCH
from slam.lines.extraction import extract_segments
from slam.lines.facets import facets_of
from slam.mapping.map_uncertainty import MapUncertainty
from slam.mapping.point_map import PointMap
from slam.mapping.surfel_map import SurfelMap
from slam.matching.force_field import match_points_to_segments
from slam.matching.surfel_mapper import SurfelMapper
from slam.matching.surfel_mapper_state import SurfelMapperState
from slam.named_code import import_optional
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

VOXEL: Final = 0.05
"""Side of a square, metres: point maps have one point, the mean, in each square."""
START_COVARIANCE: Final = np.diag([0.5**2, 0.5**2, 0.3**2])
"""Covariance of the start that our matcher gets: almost no prior knowledge."""


class Matcher(Protocol):
    """Finds the pose of the laser in its map, from a start pose near it."""

    name: str

    def match(self, scan: LaserScan, start: Pose2D) -> Pose2D:
        """Find the pose, including all work that one scan needs."""


class OurMatcher:
    """Matches facets to surfels by least squares; ``search`` adds the coarse search after a bad match."""

    def __init__(self, scans: Sequence[PlacedScan], search: bool = True) -> None:
        self.name = "ours" if search else "ours, no search"
        self._config = SlamConfig()
        assert isinstance(self._config.matching, LeastSquaresConfig)
        self._matching = self._config.matching.model_copy(update={} if search else {"search": NO_SEARCH})
        self._map = SurfelMap(SurfelMapConfig())
        for placed in scans:
            segments = extract_segments(placed.scan, self._config.lines)
            facets = facets_of(placed.scan, segments, self._matching.facet_length)
            self._map.add(facets, placed.scan, placed.T_map_laser)

    def match(self, scan: LaserScan, start: Pose2D) -> Pose2D:
        """Extract segments, make facets, and match them."""
        state = SurfelMapperState(self._map, MapUncertainty(), start, None, START_COVARIANCE)
        segments = extract_segments(scan, self._config.lines)
        match = SurfelMapper(state, self._matching, Pose2D()).locate(scan, segments, start)
        return start @ match.T_prior_laser


class PaperMatcher:
    """The paper's matcher: map points to segments of the scan by the force field, with the settings of the corridor."""

    name = "paper"

    def __init__(self, scans: Sequence[PlacedScan]) -> None:
        self._map = PointMap()
        self._map.add(voxel_means(scans), Pose2D())
        self._draw_all = PointMapConfig(draw=1.0)
        self._matching = ForceFieldConfig(gamma_M=0.3, max_iterations=300)

    def match(self, scan: LaserScan, start: Pose2D) -> Pose2D:
        """Extract segments, and move the map points that are visible from the start."""
        lines = HoppingConfig(psi=1, L_Th=min(8, max(4, len(scan.ranges) // 42)), split_gap=0.3)
        visible = self._map.draw_visible(start, scan.lidar, self._draw_all, np.random.default_rng(0))
        segments = extract_segments(scan, lines)
        return start @ match_points_to_segments(visible, segments, self._matching).T_prior_laser


class IcpMatcher:
    """small_gicp on one thread.

    It works on 3-D clouds. The normals of a flat cloud point up; so the map has three copies, one above the other,
    which makes the normals horizontal and keeps roll, pitch and height constant.
    """

    def __init__(self, scans: Sequence[PlacedScan], small_gicp: Any, kind: str) -> None:
        self.name = {"PLANE_ICP": "ICP, point to plane", "ICP": "ICP, point to point", "GICP": "GICP"}[kind]
        self._library, self._kind = small_gicp, kind
        points = voxel_means(scans)
        layers = [np.column_stack([points, np.full(len(points), z)]) for z in (-VOXEL, 0.0, VOXEL)]
        self._target = small_gicp.PointCloud(np.concatenate(layers))
        self._tree = small_gicp.KdTree(self._target)
        small_gicp.estimate_normals_covariances(self._target, self._tree, num_neighbors=20)

    def match(self, scan: LaserScan, start: Pose2D) -> Pose2D:
        """Align all points, for GICP with their covariances."""
        points = scan.points()
        source = self._library.PointCloud(np.column_stack([points, np.zeros(len(points))]))
        if self._kind == "GICP":
            self._library.estimate_covariances(source)
        T = np.eye(4)
        T[:2, :2], T[:2, 3] = start.rotation, start.translation
        found = self._library.align(
            self._target, source, self._tree, T, registration_type=self._kind,
            max_correspondence_distance=1.0, num_threads=1, max_iterations=50, rotation_epsilon=1e-4,
            translation_epsilon=1e-4,
        ).T_target_source  # fmt: skip
        return Pose2D(float(found[0, 3]), float(found[1, 3]), float(np.arctan2(found[1, 0], found[0, 0])))


def compared_matchers(scans: Sequence[PlacedScan]) -> list[Matcher]:
    """Make every matcher from the scans of the map; InputError if small_gicp is not installed."""
    small_gicp = import_optional("small_gicp", "bench")
    kinds = "PLANE_ICP", "GICP", "ICP"
    ours = [OurMatcher(scans), OurMatcher(scans, search=False)]
    return [*ours, PaperMatcher(scans), *(IcpMatcher(scans, small_gicp, kind) for kind in kinds)]


def voxel_means(scans: Sequence[PlacedScan]) -> FloatArray:
    """Return the mean (N, 2) of the points of the scans in each square; squares with one point are left out."""
    points = np.concatenate([placed.T_map_laser.transform(placed.scan.points()) for placed in scans])
    _, place, count = np.unique(np.floor(points / VOXEL), axis=0, return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(place, column) for column in points.T])
    return np.asarray((sums / count[:, np.newaxis])[count > 1])
