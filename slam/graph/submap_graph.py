"""The graph as it grows: nodes of key scans and submaps, and what joins them."""

from typing import Final

import numpy as np

from slam.graph.key_scan import KeyScan
from slam.graph.loop import Loop
from slam.graph.odometry_error import OdometryError, motion_errors
from slam.graph.pose_graph import BREAK, NO_LOOP, Edge
from slam.graph.single_poses import between, composed, undone
from slam.graph.submap import Submap
from slam.pose import FloatArray, compose_poses

CORRELATION: Final = 4.0
"""Errors of neighbouring facets are alike: the information of a match is divided by this."""
SUBMAP_SIGMAS: Final = np.array([0.005, 0.005, 0.002])
"""Metres and radians to which a scan can be matched to its own submap at best ..."""
LOOP_SIGMAS: Final = np.array([0.02, 0.02, 0.005])
"""... and to another one, whose own errors come in."""
ORIGIN_SHARE: Final = 0.1
"""Of the first variance: the key scan with which a submap begins is its origin."""
BREAK_SIGMAS: Final = np.array([0.1, 0.1, 0.1])
"""Beyond those of odometry, where the front end broke: metres and radians."""
LEAST_INFORMATION: Final = 1e-9


class SubmapGraph:
    """Key scans, submaps, and the edges between their nodes; poses are of the laser, (3,), map frame."""

    def __init__(self) -> None:
        self.keys: list[KeyScan] = []
        self.key_nodes: list[int] = []
        self.submaps: dict[int, Submap] = {}
        self.edges: list[Edge] = []
        self.loops: list[Loop] = []
        self.poses: list[FloatArray] = []
        self._number_of: dict[int, int] = {}

    def correction(self, submap: Submap) -> FloatArray:
        """``T_map_local`` (3,) as this submap has it."""
        return undone(self.poses[submap.node], submap.T_local_submap)

    def number_of(self, node: int) -> int:
        """The number of the key scan of a node."""
        return self._number_of[node]

    def add(self, key: KeyScan) -> None:
        """Add a key scan, and the submap that begins with it."""
        number, T_map_local = len(self.keys), self._T_map_local(key)
        pose = composed(T_map_local, key.T_local_laser)
        self.keys.append(key)
        self.key_nodes.append(self._new_node(pose))  # the first of all stays where it is
        self._number_of[self.key_nodes[number]] = number
        for name in key.submaps:
            if name not in self.submaps:
                broken = key.broken and name == key.submaps[0]
                self.submaps[name] = Submap(name, self._new_node(pose), key.T_local_laser, broken)
        for name in key.submaps:
            self._join_to_submap(number, self.submaps[name])

    def add_loop(self, loop: Loop) -> None:
        """Add a loop with its edges."""
        self.loops.append(loop)
        self.edges.extend(loop.edges)

    def place_keys(self) -> None:
        """Let the key scans follow their submaps."""
        at = {number: k for k, number in enumerate(self.submaps)}
        corrections = np.array([self.correction(submap) for submap in self.submaps.values()])
        local = np.array([key.T_local_laser for key in self.keys])
        placed = compose_poses(corrections[[at[key.submaps[0]] for key in self.keys]], local)
        for node, pose in zip(self.key_nodes, placed, strict=True):
            self.poses[node] = pose

    def odometry_edges(self) -> list[Edge]:
        """From each key scan to the next: their motion in ``local``, as sure as the wheels were found to be."""
        error, errors, edges = OdometryError.learnt(self.keys), motion_errors(self.keys), []
        for number in range(1, len(self.keys)):
            before, key = self.keys[number - 1], self.keys[number]
            measured = between(before.T_local_laser, key.T_local_laser) if key.trust > 0.0 else key.wheels
            covariance = error.covariance(key.wheels, errors[number])
            if key.broken:
                covariance = covariance + np.diag(BREAK_SIGMAS**2)
            information = np.asarray(np.linalg.inv(covariance), np.float64)
            loop = BREAK if key.broken else NO_LOOP
            edges.append(Edge(self.key_nodes[number - 1], self.key_nodes[number], measured, information, loop))
        return edges

    def _T_map_local(self, key: KeyScan) -> FloatArray:
        """Of the submap that it was matched to, or of the last one, where it begins a new one."""
        known = self.submaps.get(key.submaps[0]) or (self.submaps[self.keys[-1].submaps[0]] if self.keys else None)
        return np.zeros(3) if known is None else self.correction(known)

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
    """Information (3, 3) of a match in the axes of a frame at ``heading``, for one in the axes around that frame; no
    match is better than ``sigmas`` (3,)."""
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = R.T @ (information / CORRELATION) @ R
    values, vectors = np.linalg.eigh(0.5 * (turned + turned.T))
    covariance = (vectors / np.maximum(values, LEAST_INFORMATION)) @ vectors.T
    information = np.linalg.inv(covariance + np.diag(sigmas**2))
    return np.asarray(0.5 * (information + information.T))  # of what is known badly, the inverse is not quite symmetric
