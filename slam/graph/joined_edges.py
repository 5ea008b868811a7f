"""Operations on edges: invert one, chain two, fuse two between the same nodes."""

import numpy as np

from slam.graph.pose_graph import Edge
from slam.graph.single_poses import composed
from slam.pose import FloatArray, inverse_poses, wrap_angle


def lever(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the derivative (3, 3) of the product first @ second of two poses (3,) with respect to ``first``."""
    offset = composed(first, second)[:2] - first[:2]
    return np.array([[1.0, 0.0, -offset[1]], [0.0, 1.0, offset[0]], [0.0, 0.0, 1.0]])


def inverted(edge: Edge) -> Edge:
    """Return the same information with the first node relative to the second."""
    c, s = np.cos(edge.measured[2]), np.sin(edge.measured[2])
    inverse = inverse_poses(edge.measured)
    J = np.array([[-c, -s, inverse[1]], [s, -c, -inverse[0]], [0.0, 0.0, -1.0]])
    return Edge(edge.second, edge.first, inverse, _information(J @ _covariance(edge) @ J.T), edge.loop)


def joined(first: Edge, second: Edge) -> Edge:
    """Chain two edges: the second node of the second edge relative to the first node of the first."""
    assert first.second == second.first
    c, s = np.cos(first.measured[2]), np.sin(first.measured[2])
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    J = lever(first.measured, second.measured)
    covariance = J @ _covariance(first) @ J.T + R @ _covariance(second) @ R.T
    return Edge(first.first, second.second, composed(first.measured, second.measured), _information(covariance))


def fused(edge: Edge, again: Edge) -> Edge:
    """Fuse two edges between the same nodes into one."""
    assert (edge.first, edge.second) == (again.first, again.second)
    offset = again.measured - edge.measured
    offset[2] = wrap_angle(float(offset[2]))
    information = edge.information + again.information
    measured = edge.measured + np.linalg.solve(information, again.information @ offset)
    return edge._replace(measured=measured, information=information)


def inflated(edge: Edge, sigmas: FloatArray) -> Edge:
    """Return the edge with these standard deviations (3,) added to its uncertainty."""
    return edge._replace(information=_information(_covariance(edge) + np.diag(sigmas**2)))


def _covariance(edge: Edge) -> FloatArray:
    return np.asarray(np.linalg.inv(edge.information))


def _information(covariance: FloatArray) -> FloatArray:
    information = np.linalg.inv(covariance)
    return np.asarray(0.5 * (information + information.T))
