"""The growing graph: nodes of key scans and submaps, and the edges between them."""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from slam.graph.joined_edges import fused, inflated
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.graph.loop import Loop
from slam.graph.odometry_error import OdometryError, motion_errors
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge
from slam.graph.single_poses import between, composed, composed_with_inverse
from slam.graph.submap import Submap
from slam.pose import FloatArray, compose_poses

CORRELATION: Final = 4.0
"""Errors of neighbouring facets are correlated: the information of a match is divided by this."""
SUBMAP_SIGMAS: Final = np.array([0.005, 0.005, 0.002])
"""Best accuracy of a match of a scan to its own submap, metres and radians."""
LOOP_SIGMAS: Final = np.array([0.02, 0.02, 0.005])
"""Best accuracy of a match to another submap, whose own errors add."""
ORIGIN_SHARE: Final = 0.1
"""Factor on the variance of a submap's first key scan, which defines its origin."""
BREAK_SIGMAS: Final = np.array([0.1, 0.1, 0.1])
"""Standard deviations over a break of the front end, in addition to those of odometry: metres and radians."""
START_SIGMAS: Final = np.array([0.05, 0.05, 0.02])
"""Standard deviations of the start pose in the map of an earlier run: metres, radians."""
MIN_INFORMATION: Final = 1e-9
FORGOTTEN: Final = np.array([0.01, 0.01, 0.002])
"""Standard deviations, metres and radians, added to a tie when it is measured again: many rounds do not reduce its
uncertainty without bound, as the errors of the map are in all of them."""


class Remaining(NamedTuple):
    """Indices of what was kept when submaps were removed, in ascending order."""

    keys: list[int]
    loops: list[int]


class SubmapGraph:
    """Key scans, submaps, and the edges between their nodes; poses are of the laser, (3,), map frame."""

    def __init__(self, known: KnownGraph | None = None) -> None:
        self.keys: list[KeyScan] = []
        self.key_nodes: list[int] = []
        self.submaps: dict[int, Submap] = {}
        self.edges: list[Edge] = []
        self.loops: list[Loop] = []
        self.poses: list[FloatArray] = []
        self.ties: dict[tuple[int, int], Edge] = {}
        """Edges between two submaps, by their numbers.

        They replace the edges through removed submaps, and join the map of an earlier run to this run.
        """
        self.added_count = 0
        """Number of key scans that were added, including removed ones."""
        self._number_of: dict[int, int] = {}
        self._follows: list[bool] = []  # the previous key scan in the list was also taken just before it
        if known is not None:
            self._begin_with(known)

    def correction(self, submap: Submap) -> FloatArray:
        """Return ``T_map_local`` (3,) at this submap."""
        return composed_with_inverse(self.poses[submap.node], submap.T_local_submap)

    def number_of(self, node: int) -> int:
        """Return the index of the key scan of a node."""
        return self._number_of[node]

    def key_poses(self) -> FloatArray:
        """Return the poses of all key scans (K, 3)."""
        return np.array([self.poses[node] for node in self.key_nodes]).reshape(-1, 3)

    def add(self, key: KeyScan) -> None:
        """Add a key scan, and the submap that begins with it."""
        number, T_map_local, first_of_run = len(self.keys), self._T_map_local(key), self.is_first_of_run(key)
        pose = composed(T_map_local, key.T_local_laser)
        self.added_count += 1
        self._follows.append(not first_of_run)
        self.keys.append(key)
        self.key_nodes.append(self._new_node(pose))  # the first of all is fixed
        self._number_of[self.key_nodes[number]] = number
        for name in key.submaps:
            if name not in self.submaps:
                broken = (key.broken and name == key.submaps[0]) or (first_of_run and number > 0)
                self.submaps[name] = Submap(name, self._new_node(pose), key.T_local_laser, broken)
        for name in key.submaps:
            self._join_to_submap(number, self.submaps[name])
        if first_of_run and number > 0:
            self._join_to_nearest(self.submaps[key.submaps[0]])

    def is_first_of_run(self, key: KeyScan) -> bool:
        """Return True for the first key scan of this run; the key scans before it, if any, are of an earlier run."""
        return not self.keys or (self.keys[-1].index < 0 <= key.index)

    def add_loop(self, loop: Loop) -> None:
        """Add a loop with its edges."""
        self.loops.append(loop)
        self.edges.extend(loop.edges)

    def add_tie(self, tie: Edge) -> None:
        """Add an edge between two submaps, by their numbers, the lesser first."""
        at = tie.first, tie.second
        self.ties[at] = fused(inflated(self.ties[at], FORGOTTEN), tie) if at in self.ties else tie

    def tie_edges(self) -> list[Edge]:
        """Return the ties as edges between the nodes of submaps."""
        node = {number: submap.node for number, submap in self.submaps.items()}
        return [tie._replace(first=node[tie.first], second=node[tie.second]) for tie in self.ties.values()]

    def remove(self, gone: set[int]) -> Remaining:
        """Remove submaps, with the key scans that are in no other, and all their edges, loops and ties.

        The rest is renumbered, except the submaps.
        """
        left = [tuple(name for name in key.submaps if name not in gone) for key in self.keys]
        kept = [number for number, names in enumerate(left) if names]
        loops = [k for k, loop in enumerate(self.loops) if not gone & {loop.submap, loop.other}]
        for name in gone:
            del self.submaps[name]
        self.ties = {pair: tie for pair, tie in self.ties.items() if not gone.intersection(pair)}
        nodes = sorted([*(s.node for s in self.submaps.values()), *(self.key_nodes[number] for number in kept)])
        key_at, node_at, loop_at = ({old: new for new, old in enumerate(olds)} for olds in (kept, nodes, loops))
        loop_at[NO_LOOP] = NO_LOOP
        self._renumber_edges(loops, node_at, loop_at)
        for submap in self.submaps.values():
            submap.node, submap.keys = node_at[submap.node], [key_at[number] for number in submap.keys]
        self._follows = [self._follows[number] and number - 1 in key_at for number in kept]
        self.poses = [self.poses[node] for node in nodes]
        self.key_nodes = [node_at[self.key_nodes[number]] for number in kept]
        self._number_of = {node: number for number, node in enumerate(self.key_nodes)}
        self.keys[:] = [
            self.keys[k] if left[k] == self.keys[k].submaps else replace(self.keys[k], submaps=left[k]) for k in kept
        ]  # other objects hold this list
        return Remaining(kept, loops)

    def place_keys(self) -> None:
        """Move the key scans with their submaps."""
        at = {number: k for k, number in enumerate(self.submaps)}
        corrections = np.array([self.correction(submap) for submap in self.submaps.values()])
        local = np.array([key.T_local_laser for key in self.keys])
        placed = compose_poses(corrections[[at[key.submaps[0]] for key in self.keys]], local)
        for node, pose in zip(self.key_nodes, placed, strict=True):
            self.poses[node] = pose

    def odometry_edges(self) -> list[Edge]:
        """Return edges from each key scan to the next: their motion in ``local``, with the learnt odometry error."""
        follows = np.array(self._follows, np.bool_)
        error, errors, edges = OdometryError.learnt(self.keys, follows), motion_errors(self.keys, follows), []
        for number in np.flatnonzero(follows).tolist():
            before, key = self.keys[number - 1], self.keys[number]
            measured = between(before.T_local_laser, key.T_local_laser) if key.trust > 0.0 else key.wheel_motion
            covariance = error.covariance(key.wheel_motion, errors[number])
            if key.broken:
                covariance = covariance + np.diag(BREAK_SIGMAS**2)
            information = np.asarray(np.linalg.inv(covariance), np.float64)
            loop = BREAK if key.broken else NO_LOOP
            edges.append(Edge(self.key_nodes[number - 1], self.key_nodes[number], measured, information, loop))
        return edges

    def _renumber_edges(self, loops: list[int], node_at: dict[int, int], loop_at: dict[int, int]) -> None:
        """Remove the edges of removed nodes and loops."""

        def renumbered(edge: Edge) -> Edge:
            return edge._replace(first=node_at[edge.first], second=node_at[edge.second], loop=loop_at[edge.loop])

        own = [edge for edge in self.edges if edge.loop == NO_LOOP]
        own = [renumbered(edge) for edge in own if edge.first in node_at and edge.second in node_at]
        self.loops = [
            replace(loop, number=number, edges=tuple(map(renumbered, loop.edges)))
            for number, loop in enumerate(self.loops[k] for k in loops)
        ]
        self.edges = [*own, *(edge for loop in self.loops for edge in loop.edges)]

    def _T_map_local(self, key: KeyScan) -> FloatArray:
        """Return ``T_map_local`` of the submap to which a key scan was matched; if it begins one, of the last one."""
        if self.is_first_of_run(key):
            return np.zeros(3)
        known = self.submaps.get(key.submaps[0]) or self.submaps[self.keys[-1].submaps[0]]
        return self.correction(known)

    def _begin_with(self, known: KnownGraph) -> None:
        """Take over the graph of an earlier run."""
        self.keys, self.key_nodes = list(known.keys), known.graph.key_nodes.tolist()
        self.submaps, self.edges, self.loops, self.ties = known.submaps, known.edges, known.loops, known.ties
        self.poses, self.added_count = known.nodes, len(known.keys)
        self._number_of = {node: number for number, node in enumerate(self.key_nodes)}
        self._follows = [False] * len(self.keys)  # their motion is among the edges

    def _join_to_nearest(self, begun: Submap) -> None:
        """Tie the first submap of this run to the nearest one of an earlier run.

        The robot was found in that map, but loops must be able to correct a wrong start.
        """
        start = self.poses[begun.node]
        earlier = [submap for submap in self.submaps.values() if submap is not begun]
        nearest = min(earlier, key=lambda one: float(np.hypot(*(self.poses[one.node] - start)[:2])))
        measured = between(self.poses[nearest.node], start)
        tie = Edge(nearest.number, begun.number, measured, np.diag(1.0 / START_SIGMAS**2), BREAK)
        self.ties[nearest.number, begun.number] = tie

    def _new_node(self, pose: FloatArray) -> int:
        self.poses.append(pose)
        return len(self.poses) - 1

    def _join_to_submap(self, number: int, submap: Submap) -> None:
        key = self.keys[number]
        if not submap.keys:
            information = np.diag(1.0 / (ORIGIN_SHARE * SUBMAP_SIGMAS**2))
        else:
            information = key.trust * turned_information(key.information, submap.T_local_submap[2], SUBMAP_SIGMAS)
        submap.keys.append(number)
        measured = between(submap.T_local_submap, key.T_local_laser)
        self.edges.append(Edge(submap.node, self.key_nodes[number], measured, information, NO_LOOP))


def turned_information(information: FloatArray, heading: float, sigmas: FloatArray) -> FloatArray:
    """Rotate the information (3, 3) of a match into the axes of a frame at ``heading``.

    No match is better than ``sigmas`` (3,).
    """
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = R.T @ (information / CORRELATION) @ R
    values, vectors = np.linalg.eigh(0.5 * (turned + turned.T))
    covariance = (vectors / np.maximum(values, MIN_INFORMATION)) @ vectors.T
    information = np.linalg.inv(covariance + np.diag(sigmas**2))
    return np.asarray(0.5 * (information + information.T))  # not quite symmetric for large uncertainties
