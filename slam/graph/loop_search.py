"""Search of loops: a submap is searched in another one, and its key scans verify the result."""

from typing import Final

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.loop import Loop, Proposal
from slam.graph.loop_check import Check, KeyMatch, LoopCheck, distances_to
from slam.graph.place_search import Window, find_places
from slam.graph.pose_graph import Edge
from slam.graph.single_poses import between, composed, composed_with_inverse
from slam.graph.submap import Submap, SubmapMap, SubmapMaps
from slam.graph.submap_graph import LOOP_SIGMAS, SubmapGraph, turned_information
from slam.graph.submap_view import SubmapView
from slam.lines.segments import IntArray
from slam.matching.coarse_search import PLACE_X, SCORE
from slam.matching.least_squares import SolverSettings, solve
from slam.pose import FloatArray, compose_poses, wrap_angle

JOINT: Final = 6
"""Number of key scans that are searched together."""
MIN_FACETS: Final = 15
"""Least number of facets of these key scans."""
MAX_WINDOW, MAX_ANGLE = 8.0, 0.5
"""Largest half width of the window, metres and radians."""
ANY_HEADING: Final = 0.5
"""Standard deviation of the heading, radians, above which every heading is tried."""
SIGMAS: Final = 3.0
"""Half width of the window in standard deviations."""
MIN_SHARE: Final = 0.3
"""Least share of facets on walls for a pose to be refined."""
PLACES: Final = 4
"""Largest number of poses that are refined."""
FOLLOWED_SHARE: Final = 0.75
"""Least share of the best score for a pose to be refined."""
FOUND_INFORMATION: Final = np.diag(1.0 / np.array([0.3, 0.3, 0.1]) ** 2)
"""Information of a pose from the search: metres and radians."""
AMBIGUOUS: Final = 0.9
"""Share of the best agreement with which a second pose makes the direction between them unconstrained."""
APART, TURNED = 0.3, 0.1
"""A second pose counts if it is farther than this from the best, metres; if it is turned by more, radians, both are
rejected."""
OWN_SIGMAS: Final = np.array([0.1, 0.1, 0.02])
"""Standard deviations of the path within submaps, metres and radians, added to those of the graph."""


class LoopSearch:
    """Searches submaps of a graph in each other."""

    def __init__(self, graph: SubmapGraph, matching: LeastSquaresConfig, config: SurfelMapConfig) -> None:
        self._graph, self._config = graph, config
        self._maps = SubmapMaps(config, graph.keys)
        shared = {name: getattr(matching, name) for name in SolverSettings._fields if name != "standing_length"}
        self._settings = SolverSettings(**shared, standing_length=0.0)
        self._check = LoopCheck(self._settings, config)

    def view(self, submap: Submap) -> SubmapView:
        """Return a submap in the form in which it is searched in others."""
        return SubmapView(submap, self._graph.keys, self._config.no_echo_reach)

    def map_of(self, submap: Submap) -> SubmapMap:
        """Return the map of a finished submap."""
        return self._maps.of(submap)

    def find(self, view: SubmapView, other: Submap, covariance: FloatArray, proposal: Proposal) -> Loop | None:
        """Search a submap in another one.

        ``covariance`` (3, 3) is that of the node of ``other`` relative to the node of ``view``, map axes. None if the
        two submaps do not agree.
        """
        T_other_submap = between(self._graph.correction(other), self._graph.correction(view.submap))
        middle = _nearest_first(view, other, T_other_submap)[0]
        prior = composed(T_other_submap, view.path[middle])
        return self.find_near(view, other, T_other_submap, self._covariance_there(other, covariance, prior), proposal)

    def find_near(
        self, view: SubmapView, other: Submap, T_other_submap: FloatArray, covariance: FloatArray, proposal: Proposal
    ) -> Loop | None:
        """Search a submap near a pose in another one.

        ``covariance`` (3, 3) is that of one key scan of ``view``, the nearest to the path of ``other``, with the axes
        of the frame ``local`` of ``other``.
        """
        nearest_first = _nearest_first(view, other, T_other_submap)
        middle = int(nearest_first[0])
        facets = view.joint_scan(middle, nearest_first[:JOINT])
        if len(facets) < MIN_FACETS:
            return None
        window = _window(composed(T_other_submap, view.path[middle]), covariance, len(facets))
        grid, pictures = self.map_of(other)
        places = find_places(facets, window, pictures, MIN_SHARE, PLACES)
        settings = self._settings._replace(first_kernel=8.0 * self._settings.kernel)
        checks = []
        for place in places[places[:, SCORE] >= FOLLOWED_SHARE * places[:, SCORE].max(initial=0.0)]:
            start = place[PLACE_X:].copy()
            fit = solve(facets, start, start, FOUND_INFORMATION, grid, settings)
            found = composed_with_inverse(fit.pose, view.path[middle])
            checks.append(self._check.check(view, found, other, grid))
        checks.sort(key=lambda check: -check.agreement)
        if not checks or not checks[0].passed:
            return None
        direction, contradicted = _second_place(checks, view.path[middle])
        if contradicted:
            return None
        if direction is None:
            direction = self._check.open_direction(view, checks[0], grid)
        return self._loop(view, other, checks[0], direction, proposal)

    def _covariance_there(self, other: Submap, covariance: FloatArray, prior: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of a pose relative to the other submap, axes of its frame ``local``."""
        correction = self._graph.correction(other)
        there, node = composed(correction, prior), self._graph.poses[other.node]
        J = np.eye(3)
        J[0, 2], J[1, 2] = node[1] - there[1], there[0] - node[0]
        c, s = np.cos(correction[2]), np.sin(correction[2])
        R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(R @ J @ covariance @ J.T @ R.T + np.diag(OWN_SIGMAS**2))

    def _loop(
        self, view: SubmapView, other: Submap, check: Check, direction: FloatArray | None, proposal: Proposal
    ) -> Loop:
        """Make the loop; along an unconstrained direction (2,) the submap stays at its previous estimate."""
        graph, submap, T_other_submap = self._graph, view.submap, check.T_other_submap
        shift = np.zeros(3)
        if direction is not None:
            thought = composed(between(graph.correction(other), graph.correction(submap)), submap.T_local_submap)
            offset = (thought - composed(T_other_submap, submap.T_local_submap))[:2]
            shift[:2] = (offset @ direction) * direction
            T_other_submap = T_other_submap + shift
        number = len(graph.loops)
        edges = tuple(self._edge(view, match, other, number, direction, shift) for match in check.agreeing)
        return Loop(
            number, submap.number, other.number, T_other_submap, proposal, len(check.matches), len(edges),
            check.agreement / len(check.matches), direction is not None, edges, view.keys[-1].index,
        )  # fmt: skip

    def _edge(
        self, view: SubmapView, match: KeyMatch, other: Submap, number: int, direction: FloatArray | None,
        shift: FloatArray,
    ) -> Edge:  # fmt: skip
        information = match.information if direction is None else _without(match.information, direction)
        information = turned_information(information, float(other.T_local_submap[2]), LOOP_SIGMAS)
        measured = between(other.T_local_submap, match.pose + shift)
        return Edge(other.node, self._graph.key_nodes[view.submap.keys[match.at]], measured, information, number)


def _nearest_first(view: SubmapView, other: Submap, T_other_submap: FloatArray) -> IntArray:
    """Return the key scans of a submap at a pose in another one, nearest to the other's path first."""
    return np.argsort(distances_to(compose_poses(T_other_submap, view.path), other.path), kind="stable")


def _window(prior: FloatArray, covariance: FloatArray, facets: int) -> Window:
    """Return the window of poses around a prior (3,) with this covariance (3, 3)."""
    width = min(MAX_WINDOW, SIGMAS * float(np.sqrt(max(covariance[0, 0], covariance[1, 1]))))
    most_angle = np.pi if covariance[2, 2] > ANY_HEADING**2 else MAX_ANGLE
    angle = min(most_angle, SIGMAS * float(np.sqrt(covariance[2, 2])))
    return Window.about(prior, np.linalg.inv(covariance) / facets, width, angle)


def _second_place(checks: list[Check], own: FloatArray) -> tuple[FloatArray | None, bool]:
    """Return the direction (2,) to a second pose that is nearly as good, or None.

    The second value is True if that pose is rotated, so that the first is rejected too. The poses are those of the key
    scan at ``own`` (3,).
    """
    best = composed(checks[0].T_other_submap, own)
    for check in checks[1:]:
        place = composed(check.T_other_submap, own)
        offset = place[:2] - best[:2]
        turned = abs(wrap_angle(float(place[2] - best[2]))) > TURNED
        apart = float(np.hypot(*offset))
        if check.agreement > AMBIGUOUS * checks[0].agreement and (turned or apart > APART):
            return offset / max(apart, 1e-9), turned
    return None, False


def _without(information: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the information (3, 3) without its part along a direction (2,) of the position."""
    d = np.append(direction, 0.0)
    along = information @ d
    return np.asarray(information - np.outer(along, along) / max(float(d @ along), 1e-9))
