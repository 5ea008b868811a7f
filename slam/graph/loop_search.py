"""Search of a loop: a submap is sought in another one, and what is found is verified by its key scans."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from slam.config import LeastSquaresConfig, SurfelMapConfig
from slam.graph.loop import Loop, Proposal
from slam.graph.loop_check import KeyMatch, match_key
from slam.graph.place_search import Window, find_places
from slam.graph.pose_graph import Edge
from slam.graph.submap import Submap, SubmapGrids, path_of
from slam.graph.submap_graph import LOOP_SIGMAS, SubmapGraph, turned_information
from slam.lines.facets import NX, NY, X, Y
from slam.mapping.surfel_grid import Grid
from slam.matching.coarse_search import PLACE_X
from slam.matching.least_squares import SolverSettings, solve
from slam.pose import FloatArray, compose_poses, inverse_poses, relative_poses, wrap_angle

JOINT: Final = 6
"""Key scans that are sought together."""
REACH: Final = 15.0
"""Metres: facets farther from the sensor take no part in the search."""
LEAST_FACETS, MOST_FACETS = 15, 350
"""Facets that are sought together."""
MOST_WINDOW, MOST_ANGLE = 8.0, 0.5
"""Half the window, metres and radians, at most ..."""
ANY_HEADING: Final = 0.5
"""... unless the heading is known worse than this, radians: then every one is tried."""
SIGMAS: Final = 3.0
"""Standard deviations that the window reaches to each side."""
LEAST_SHARE: Final = 0.3
"""Share of the facets that must lie on walls for a place to be followed up."""
PLACES: Final = 4
"""Places that are followed up."""
FOUND_INFORMATION: Final = np.diag(1.0 / np.array([0.3, 0.3, 0.1]) ** 2)
"""Of a place from the search: metres and radians."""
NEAR: Final = 3.0
"""Metres from the path of the other submap, within which a key scan is asked."""
LEAST_AGREEING, LEAST_AGREEING_SHARE = 2, 0.5
"""Key scans that must agree, and share of those that were asked."""
AMBIGUOUS: Final = 0.9
"""A second place with this share of the agreement of the first leaves the direction between them open ..."""
APART, TURNED = 0.3, 0.1
"""... where they are so far apart, metres; where their headings differ by so much, radians, neither is believed."""
OWN_SIGMAS: Final = np.array([0.1, 0.1, 0.02])
"""Errors of the path within submaps, metres and radians, added to what the graph says."""


class _Place(NamedTuple):
    """A place that was followed up."""

    T_other_submap: FloatArray
    """(3,), between the frames ``local`` of the two."""
    reference: FloatArray
    """(3,): the pose of the key scan in the middle, in the other's frame."""
    matches: list[KeyMatch]
    agreement: float
    """Sum over the key scans that were asked."""


class LoopSearch:
    """Compares submaps of a graph."""

    def __init__(self, graph: SubmapGraph, matching: LeastSquaresConfig, config: SurfelMapConfig) -> None:
        self._graph, self._config = graph, config
        self.grids = SubmapGrids(config, graph.keys)
        shared = {name: getattr(matching, name) for name in SolverSettings._fields if name != "standing_way"}
        self._settings = SolverSettings(**shared, standing_way=0.0)

    def find(self, submap: Submap, other: Submap, covariance: FloatArray, proposal: Proposal) -> Loop | None:
        """Seek a submap in another one; ``covariance`` (3, 3) is that of the other's node as seen from the first, map
        axes. None where they do not agree."""
        graph = self._graph
        T_other_submap = relative_poses(graph.correction(other), graph.correction(submap))
        path, other_path = path_of(submap, graph.keys), path_of(other, graph.keys)
        seen = compose_poses(T_other_submap, path)
        distances = _distances(seen, other_path)
        middle = int(np.argmin(distances))
        prior = seen[middle]
        at_prior = self._covariance_there(other, covariance, prior)
        return self.find_near(submap, other, prior, at_prior, middle, np.argsort(distances, kind="stable"), proposal)

    def find_near(
        self, submap: Submap, other: Submap, prior: FloatArray, covariance: FloatArray, middle: int,
        nearest: Sequence[int] | np.ndarray, proposal: Proposal,
    ) -> Loop | None:  # fmt: skip
        """Seek a key scan, the ``middle`` one of its submap, about ``prior`` (3,), frame ``local`` of the other."""
        facets = self._joint_scan(submap, middle, nearest[:JOINT])
        if len(facets) < LEAST_FACETS:
            return None
        grid, path = self.grids.of(other), path_of(submap, self._graph.keys)
        width = min(MOST_WINDOW, SIGMAS * float(np.sqrt(max(covariance[0, 0], covariance[1, 1]))))
        any_heading = covariance[2, 2] > ANY_HEADING**2
        angle = min(np.pi if any_heading else MOST_ANGLE, SIGMAS * float(np.sqrt(covariance[2, 2])))
        information = np.linalg.inv(covariance) / len(facets)
        window = Window.about(prior, information, width, angle)
        found = []
        for place in find_places(facets, window, grid, REACH, LEAST_SHARE, PLACES):
            start = place[PLACE_X:].copy()
            first_kernel = 8.0 * self._settings.kernel
            fit = solve(
                facets, start, start, FOUND_INFORMATION, grid, self._settings._replace(first_kernel=first_kernel)
            )
            found.append(self._followed(submap, other, grid, fit.pose, path[middle]))
        return self._loop(submap, other, found, proposal)

    def _covariance_there(self, other: Submap, covariance: FloatArray, prior: FloatArray) -> FloatArray:
        """Covariance (3, 3) of a place seen from the other submap, axes of its frame ``local``."""
        correction = self._graph.correction(other)
        there, node = compose_poses(correction, prior), self._graph.poses[other.node]
        J = np.eye(3)
        J[0, 2], J[1, 2] = node[1] - there[1], there[0] - node[0]
        c, s = np.cos(correction[2]), np.sin(correction[2])
        R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(R @ J @ covariance @ J.T @ R.T + np.diag(OWN_SIGMAS**2))

    def _joint_scan(self, submap: Submap, middle: int, numbers: Sequence[int] | np.ndarray) -> FloatArray:
        """The facets of some key scans together, in the frame of the one in the middle."""
        graph, parts = self._graph, []
        origin = graph.keys[submap.keys[middle]].T_local_laser
        for number in numbers:
            key = graph.keys[submap.keys[number]]
            parts.append(_moved(key.facets, relative_poses(origin, key.T_local_laser)))
        facets = np.concatenate(parts)
        facets = facets[np.hypot(facets[:, X], facets[:, Y]) < REACH]
        return np.ascontiguousarray(facets[:: len(facets) // MOST_FACETS + 1])

    def _followed(self, submap: Submap, other: Submap, grid: Grid, reference: FloatArray, own: FloatArray) -> _Place:
        """Ask all key scans that lie near the other's path when the one at ``own`` (3,) lies at ``reference``."""
        graph = self._graph
        T_other_submap = compose_poses(reference, inverse_poses(own))
        poses = compose_poses(T_other_submap, path_of(submap, graph.keys))
        near = _distances(poses, path_of(other, graph.keys)) <= NEAR
        settings = self._settings._replace(first_kernel=4.0 * self._settings.kernel)
        matches = []
        for at in np.flatnonzero(near):
            number = submap.keys[at]
            match = match_key(number, graph.keys[number], poses[at], grid, settings, self._config)
            if match is not None:
                matches.append(match)
        return _Place(T_other_submap, reference, matches, sum(match.agreement for match in matches))

    def _loop(self, submap: Submap, other: Submap, found: list[_Place], proposal: Proposal) -> Loop | None:
        if not found:
            return None
        found = sorted(found, key=lambda place: -place.agreement)
        best = found[0]
        agreeing = [match for match in best.matches if match.agrees]
        if len(agreeing) < max(LEAST_AGREEING, LEAST_AGREEING_SHARE * len(best.matches)):
            return None
        direction = None
        for place in found[1:]:
            offset = relative_poses(best.reference, place.reference)
            turned = abs(wrap_angle(float(offset[2]))) > TURNED
            if place.agreement > AMBIGUOUS * best.agreement and (turned or np.hypot(*offset[:2]) > APART):
                if turned:
                    return None
                direction = place.reference[:2] - best.reference[:2]
                break
        number = len(self._graph.loops)
        edges = tuple(self._edge(match, other, number, direction) for match in agreeing)
        return Loop(
            number, submap.number, other.number, best.T_other_submap, proposal, len(best.matches), len(agreeing),
            best.agreement / max(len(best.matches), 1), direction is not None, edges,
            self._graph.keys[submap.keys[-1]].index,
        )  # fmt: skip

    def _edge(self, match: KeyMatch, other: Submap, number: int, open_direction: FloatArray | None) -> Edge:
        information = match.information
        if open_direction is not None:
            information = _without(information, open_direction)
        information = turned_information(information, float(other.T_local_submap[2]), LOOP_SIGMAS)
        measured = relative_poses(other.T_local_submap, match.pose)
        return Edge(other.node, self._graph.key_nodes[match.key], measured, information, number)


def _without(information: FloatArray, direction: FloatArray) -> FloatArray:
    """The information (3, 3) without what it says along a direction (2,) of the place."""
    d = np.append(direction / np.linalg.norm(direction), 0.0)
    along = information @ d
    return np.asarray(information - np.outer(along, along) / max(float(d @ along), 1e-9))


def _moved(facets: FloatArray, pose: FloatArray) -> FloatArray:
    """Facets (F, 7) of a scan at ``pose`` (3,)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    moved = facets.copy()
    moved[:, X], moved[:, Y] = (
        pose[0] + c * facets[:, X] - s * facets[:, Y],
        pose[1] + s * facets[:, X] + c * facets[:, Y],
    )
    moved[:, NX], moved[:, NY] = c * facets[:, NX] - s * facets[:, NY], s * facets[:, NX] + c * facets[:, NY]
    return moved


def _distances(path: FloatArray, other: FloatArray) -> FloatArray:
    """Metres from each pose (K, 3) to the nearest of the others (J, 3), shape (K,)."""
    offsets = path[:, None, :2] - other[None, :, :2]
    return np.asarray(np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1))
