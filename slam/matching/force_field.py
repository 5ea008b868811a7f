"""Self-localisation by a force field: the segments of the present scan pull the points of the map. Section 4.2.

The map points move and the segments stand still (Fig. 9); the motion that brings the points onto the segments is the
inverse of the motion of the sensor: hence the minus signs of eqs. (21), (34) and (35).
"""

from __future__ import annotations

import numpy as np

from slam.compiled import compiled
from slam.config import ForceFieldConfig
from slam.lines.segments import Segments
from slam.matching.match import NO_MATCH, Match
from slam.pose import FloatArray, Pose2D, wrap_angle


def match_points_to_segments(points: FloatArray, segments: Segments, config: ForceFieldConfig) -> Match:
    """Move the map points w* (N*, 2) onto the segments of the present scan, both given in the prior's sensor frame."""
    if len(points) == 0 or len(segments) == 0:
        return NO_MATCH
    x, y = np.ascontiguousarray(points.T)
    dx, dy, dphi, iterations, converged = _iterate(
        x, y, _lines(segments), config.average == "weighted", config.gamma_f, config.kappa, config.epsilon,
        config.gamma_M, config.xi, config.eta, config.zeta, config.rho_f, config.rho_M, config.max_iterations,
    )  # fmt: skip
    # Eq. (21) rotates first, so the sensor moved by T(dphi) dX; eq. (19) adds dX, which is the same to first order.
    return Match(Pose2D(theta=wrap_angle(dphi)) @ Pose2D(dx, dy), iterations, converged, len(points))


def _lines(segments: Segments) -> FloatArray:
    """One row a segment, shape (M, 7): e_n, rho, e_t, the start point along e_t, the length along e_t."""
    e_n = segments.normals  # eq. (25)
    e_t = np.column_stack([-e_n[:, 1], e_n[:, 0]])  # eq. (29)
    length = np.sum(e_t * (segments.end - segments.start), axis=1)  # eq. (30)
    e_t[length < 0.0] *= -1.0  # from P to Q, or the window of eq. (24) is empty
    start = np.sum(e_t * segments.start, axis=1)  # where lambda_t is 0: eq. (31)
    return np.column_stack([e_n, segments.rho, e_t, start, np.abs(length)])


@compiled
def _iterate(
    x: FloatArray, y: FloatArray, lines: FloatArray, weighted: bool, gamma_f: float, kappa: float, epsilon: float,
    gamma_M: float, xi: float, eta: float, zeta: float, rho_f: float, rho_M: float, max_iterations: int,
) -> tuple[float, float, float, int, bool]:  # fmt: skip
    """Eqs. (21)-(37): Delta X (x, y), Delta phi, the number of iterations, and whether they converged."""
    dx = dy = dphi = 0.0
    sum_fx = sum_fy = sum_M = 0.0
    wx, wy = np.empty_like(x), np.empty_like(y)
    for q in range(1, max_iterations + 1):
        c, s = np.cos(dphi), np.sin(dphi)
        for i in range(len(x)):  # eq. (21)
            wx[i] = c * x[i] + s * y[i] - dx
            wy[i] = c * y[i] - s * x[i] - dy
        fx, fy, M = _correction(wx, wy, lines, weighted, gamma_f, kappa, epsilon, gamma_M)
        dx = xi * dx - eta * fx - zeta * sum_fx  # eq. (34); from rest, where 1 - xi = zeta, it is -sum f
        dy = xi * dy - eta * fy - zeta * sum_fy
        dphi = xi * dphi - eta * M - zeta * sum_M  # eq. (35)
        if np.hypot(fx, fy) < rho_f and abs(M) < rho_M:
            return dx, dy, dphi, q, True  # eqs. (36) and (37)
        sum_fx, sum_fy, sum_M = sum_fx + fx, sum_fy + fy, sum_M + M
    return dx, dy, dphi, max_iterations, False


@compiled
def _correction(
    wx: FloatArray, wy: FloatArray, lines: FloatArray, weighted: bool, gamma_f: float, kappa: float, epsilon: float,
    gamma_M: float,
) -> tuple[float, float, float]:  # fmt: skip
    """f_q (x, y) and M_q, the averages of eq. (33) over all points and segments, or weighted ones."""
    gx, gy = wx.mean(), wy.mean()  # eq. (23): of the N* points in sight, where eq. (22) prints N_map
    fx = fy = M = weight = inertia = 0.0
    for m in range(len(lines)):
        nx, ny, rho, tx, ty, start, length = lines[m]
        pull, pull_x, pull_y = _pull(wx, wy, nx, ny, rho, tx, ty, start, length, kappa, epsilon)
        fx += nx * pull
        fy += ny * pull
        M += (pull_x - gx * pull) * ny - (pull_y - gy * pull) * nx  # eq. (32), with the sign that a norm loses
        if weighted:
            w, w_rr = _weight(wx, wy, nx, ny, rho, tx, ty, start, length, gx, gy, kappa, epsilon)
            weight += w
            inertia += w_rr
    if weighted:
        return (fx / weight, fy / weight, gamma_M * M / inertia) if inertia > 0.0 else (0.0, 0.0, 0.0)
    gain = gamma_f / (len(lines) * len(wx))
    return gain * fx, gain * fy, gamma_M * gain * M  # eq. (33)


@compiled
def _pull(
    wx: FloatArray, wy: FloatArray, nx: float, ny: float, rho: float, tx: float, ty: float, start: float, length: float,
    kappa: float, epsilon: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Sums over the points of the force of one segment along e_n, over gamma_f, and of the same times x and times y."""
    pull = pull_x = pull_y = 0.0
    for i in range(len(wx)):
        lam = rho - nx * wx[i] - ny * wy[i]  # eq. (26)
        lam_t = tx * wx[i] + ty * wy[i] - start  # eqs. (27) and (28): R differs from w along e_n only
        distance = abs(lam)
        fall = distance * distance * distance if kappa == 3.0 else distance**kappa
        force = lam / (fall + epsilon) if 0.0 <= lam_t <= length else 0.0  # eq. (24)
        pull += force
        pull_x += force * wx[i]
        pull_y += force * wy[i]
    return pull, pull_x, pull_y


@compiled
def _weight(
    wx: FloatArray, wy: FloatArray, nx: float, ny: float, rho: float, tx: float, ty: float, start: float, length: float,
    gx: float, gy: float, kappa: float, epsilon: float,
) -> tuple[float, float]:  # fmt: skip
    """Sums over the points of the weight that the force of one segment gives them, and of the same times |w - G|^2."""
    weight = inertia = 0.0
    for i in range(len(wx)):
        distance = abs(rho - nx * wx[i] - ny * wy[i])
        lam_t = tx * wx[i] + ty * wy[i] - start
        fall = distance * distance * distance if kappa == 3.0 else distance**kappa
        share = 1.0 / (fall + epsilon) if 0.0 <= lam_t <= length else 0.0
        weight += share
        inertia += share * ((wx[i] - gx) ** 2 + (wy[i] - gy) ** 2)
    return weight, inertia
