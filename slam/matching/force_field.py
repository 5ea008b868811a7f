"""Self-localisation by a force field: the segments of the present scan pull the points of the map. Section 4.2.

The map points move and the segments stand still (Fig. 9); the motion that brings the points onto the segments is the
inverse of the motion of the sensor: hence the minus signs of eqs. (21), (34) and (35).
"""

from typing import NamedTuple

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.config import ForceFieldConfig
from slam.lines.segments import Segments
from slam.matching.match import NO_MATCH, Match
from slam.pose import FloatArray, Pose2D, wrap_angle


class ForceFieldConstants(NamedTuple):
    """Constants of eqs. (24)-(37), those of ForceFieldConfig: metres and radians."""

    gamma_f: float
    kappa: float
    epsilon: float
    gamma_M: float
    xi: float
    eta: float
    zeta: float
    rho_f: float
    rho_M: float
    max_iterations: int


class Line(NamedTuple):
    """Line of a segment: e_n, rho, e_t, the start point along e_t, the length along e_t."""

    nx: float
    ny: float
    rho: float
    tx: float
    ty: float
    start: float
    length: float


def match_points_to_segments(points: FloatArray, segments: Segments, config: ForceFieldConfig) -> Match:
    """Move the map points w* (N*, 2) onto the segments of the present scan, both given in the prior's sensor frame."""
    if len(points) == 0 or len(segments) == 0:
        return NO_MATCH
    x, y = np.ascontiguousarray(points.T)
    dx, dy, dphi, iterations, converged = _iterate(
        x, y, _lines(segments), _constants(config), config.average == "weighted"
    )
    # Eq. (21) rotates first, so the sensor moved by T(dphi) dX; eq. (19) adds dX, which is the same to first order.
    return Match(Pose2D(theta=wrap_angle(dphi)) @ Pose2D(dx, dy), iterations, converged, len(points))


def _constants(config: ForceFieldConfig) -> ForceFieldConstants:
    return ForceFieldConstants(*(getattr(config, name) for name in ForceFieldConstants._fields))


def _lines(segments: Segments) -> FloatArray:
    """Return one row per segment, with the columns of Line, shape (M, 7)."""
    e_n = segments.normals  # eq. (25)
    e_t = np.column_stack([-e_n[:, 1], e_n[:, 0]])  # eq. (29)
    length = np.sum(e_t * (segments.end - segments.start), axis=1)  # eq. (30)
    e_t[length < 0.0] *= -1.0  # from P to Q, or the window of eq. (24) is empty
    start = np.sum(e_t * segments.start, axis=1)  # where lambda_t is 0: eq. (31)
    return np.column_stack([e_n, segments.rho, e_t, start, np.abs(length)])


@compiled
def _iterate(
    x: FloatArray, y: FloatArray, lines: FloatArray, constants: ForceFieldConstants, weighted: bool
) -> tuple[float, float, float, int, bool]:
    """Iterate eqs. (21)-(37): Delta X (x, y), Delta phi, the number of iterations, and whether they converged."""
    xi, eta, zeta = constants.xi, constants.eta, constants.zeta
    dx = dy = dphi = 0.0
    sum_fx = sum_fy = sum_M = 0.0
    wx, wy = np.empty_like(x), np.empty_like(y)
    for q in range(1, constants.max_iterations + 1):
        c, s = np.cos(dphi), np.sin(dphi)
        for i in range(len(x)):  # eq. (21)
            wx[i] = c * x[i] + s * y[i] - dx
            wy[i] = c * y[i] - s * x[i] - dy
        if weighted:
            fx, fy, M = _weighted_correction(wx, wy, lines, constants)  # not in the paper
        else:
            fx, fy, M = _correction(wx, wy, lines, constants)  # eqs. (22)-(33)
        dx = xi * dx - eta * fx - zeta * sum_fx  # eq. (34); from rest, where 1 - xi = zeta, it is -sum f
        dy = xi * dy - eta * fy - zeta * sum_fy
        dphi = xi * dphi - eta * M - zeta * sum_M  # eq. (35)
        if np.hypot(fx, fy) < constants.rho_f and abs(M) < constants.rho_M:
            return dx, dy, dphi, q, True  # eqs. (36) and (37)
        sum_fx, sum_fy, sum_M = sum_fx + fx, sum_fy + fy, sum_M + M
    return dx, dy, dphi, constants.max_iterations, False


@compiled
def _correction(
    wx: FloatArray, wy: FloatArray, lines: FloatArray, constants: ForceFieldConstants
) -> tuple[float, float, float]:
    """Return f_q (x, y) and M_q, the averages of eq. (33) over all points and segments."""
    fx, fy, M = _sum_forces(wx, wy, lines, constants.kappa, constants.epsilon)
    gain = constants.gamma_f / (len(lines) * len(wx))
    return gain * fx, gain * fy, constants.gamma_M * gain * M  # eq. (33)


@compiled
def _sum_forces(
    wx: FloatArray, wy: FloatArray, lines: FloatArray, kappa: float, epsilon: float
) -> tuple[float, float, float]:
    """Sum the force, over gamma_f, and its moment, over gamma_f gamma_M, over all points and segments."""
    gx, gy = wx.mean(), wy.mean()  # eq. (23): of the N* points in sight, where eq. (22) prints N_map
    fx = fy = M = 0.0
    for m in range(len(lines)):
        nx, ny, rho, tx, ty, start, length = lines[m]
        pull, pull_x, pull_y = _pull(wx, wy, Line(nx, ny, rho, tx, ty, start, length), kappa, epsilon)
        fx += nx * pull
        fy += ny * pull
        M += (pull_x - gx * pull) * ny - (pull_y - gy * pull) * nx  # eq. (32), with the sign that a norm loses
    return fx, fy, M


@compiled_on_views
def _pull(wx: FloatArray, wy: FloatArray, line: Line, kappa: float, epsilon: float) -> tuple[float, float, float]:
    """Sum the force of one segment along e_n, over gamma_f, over the points; and the same times x and times y."""
    pull = pull_x = pull_y = 0.0
    for i in range(len(wx)):
        lam = line.rho - line.nx * wx[i] - line.ny * wy[i]  # eq. (26)
        lam_t = line.tx * wx[i] + line.ty * wy[i] - line.start  # eqs. (27) and (28): R differs from w along e_n only
        distance = abs(lam)
        fall = distance * distance * distance if kappa == 3.0 else distance**kappa
        force = lam / (fall + epsilon) if 0.0 <= lam_t <= line.length else 0.0  # eq. (24)
        pull += force
        pull_x += force * wx[i]
        pull_y += force * wy[i]
    return pull, pull_x, pull_y


# Not in the paper: the forces averaged by their weights, see ``average`` in ForceFieldConfig.


@compiled
def _weighted_correction(
    wx: FloatArray, wy: FloatArray, lines: FloatArray, constants: ForceFieldConstants
) -> tuple[float, float, float]:
    """Return f_q (x, y) and M_q: force over sum of weights, moment over weighted moment of inertia."""
    kappa, epsilon = constants.kappa, constants.epsilon
    fx, fy, M = _sum_forces(wx, wy, lines, kappa, epsilon)
    gx, gy = wx.mean(), wy.mean()
    weight = inertia = 0.0
    for m in range(len(lines)):
        nx, ny, rho, tx, ty, start, length = lines[m]
        w, w_rr = _sum_weights(wx, wy, Line(nx, ny, rho, tx, ty, start, length), gx, gy, kappa, epsilon)
        weight += w
        inertia += w_rr
    return (fx / weight, fy / weight, constants.gamma_M * M / inertia) if inertia > 0.0 else (0.0, 0.0, 0.0)


@compiled_on_views
def _sum_weights(
    wx: FloatArray, wy: FloatArray, line: Line, gx: float, gy: float, kappa: float, epsilon: float
) -> tuple[float, float]:
    """Sum the weights that the force of one segment gives the points, and the same times |w - G|^2."""
    weight = inertia = 0.0
    for i in range(len(wx)):
        distance = abs(line.rho - line.nx * wx[i] - line.ny * wy[i])
        lam_t = line.tx * wx[i] + line.ty * wy[i] - line.start
        fall = distance * distance * distance if kappa == 3.0 else distance**kappa
        share = 1.0 / (fall + epsilon) if 0.0 <= lam_t <= line.length else 0.0
        weight += share
        inertia += share * ((wx[i] - gx) ** 2 + (wy[i] - gy) ** 2)
    return weight, inertia
