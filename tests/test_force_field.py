"""Matching by forces: laws, the equations as printed, then known displacements."""

from math import hypot

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.config import ForceFieldConfig, HoppingConfig
from slam.lines.hopping import segments_by_hopping
from slam.lines.segments import Segments
from slam.matching.force_field import (
    _constants,
    _correction,
    _lines,
    _weighted_correction,
    match_points_to_segments,
)
from slam.matching.match import NO_MATCH
from slam.pose import FloatArray, Pose2D

CONFIG = ForceFieldConfig(gamma_M=1.0)
WEIGHTED = ForceFieldConfig(gamma_M=1.0, average="weighted")


def room(T_room_laser: Pose2D, noise: float = 0.0, seed: int = 0) -> FloatArray:
    """Points on the walls of a room of 6 m by 3.5 m, sensor frame, in the order of their bearing."""
    bearings = np.linspace(-2.0, 2.0, 128)
    directions = np.column_stack([np.cos(bearings + T_room_laser.theta), np.sin(bearings + T_room_laser.theta)])
    corners = np.array([[3.0, 2.0], [-3.0, -1.5]]) - T_room_laser.translation
    with np.errstate(divide="ignore"):
        ranges = np.where(directions > 0, corners[0] / directions, corners[1] / directions).min(axis=1)
    ranges += np.random.default_rng(seed).normal(0, 1, len(ranges)) * noise
    return np.column_stack([ranges * np.cos(bearings), ranges * np.sin(bearings)])


def printed_correction(w: FloatArray, segments: Segments, config: ForceFieldConfig) -> tuple[FloatArray, float]:
    """Eqs. (23) to (33), point by point and segment by segment."""
    G_c = w.mean(axis=0)  # (23)
    f, M = np.zeros(2), 0.0
    for m in range(len(segments)):
        theta, rho = segments.theta[m], segments.rho[m]
        e_n = np.array([np.cos(theta), np.sin(theta)])  # (25)
        e_t = np.array([-np.sin(theta), np.cos(theta)])  # (29)
        if e_t @ (segments.end[m] - segments.start[m]) < 0:
            e_t = -e_t
        lambda_Q = e_t @ (segments.end[m] - segments.start[m])  # (30)
        for i in range(len(w)):
            lam = -(e_n @ w[i] - rho)  # (26)
            R = w[i] + lam * e_n  # (27)
            lambda_t = e_t @ (R - segments.start[m])  # (28)
            if 0 <= lambda_t <= lambda_Q:
                delta_f = config.gamma_f * lam / (abs(lam) ** config.kappa + config.epsilon) * e_n  # (24)
                f += delta_f
                arm = w[i] - G_c
                M += config.gamma_M * (arm[0] * delta_f[1] - arm[1] * delta_f[0])  # (32)
    return f / (len(segments) * len(w)), M / (len(segments) * len(w))  # (33)


@settings(max_examples=25)
@given(st.integers(0, 1000), st.sampled_from([2.0, 3.0, 3.5]))
def test_the_compiled_forces_are_those_of_the_equations(seed: int, kappa: float) -> None:
    config = ForceFieldConfig(gamma_M=2.0, kappa=kappa)
    segments = segments_by_hopping(room(Pose2D(), 0.01, seed), HoppingConfig())
    w = room(Pose2D(0.03, -0.02, 0.02), 0.01, seed + 1)[::5]
    x, y = np.ascontiguousarray(w.T)
    fx, fy, M = _correction(x, y, _lines(segments), _constants(config))
    f_printed, M_printed = printed_correction(w, segments, config)
    np.testing.assert_allclose([fx, fy], f_printed, rtol=1e-9, atol=1e-15)
    assert M == pytest.approx(M_printed, rel=1e-9, abs=1e-15)


@settings(max_examples=25)
@given(st.integers(0, 1000), st.sampled_from([2.0, 3.0, 3.5]))
def test_the_weighted_average_divides_by_the_weights(seed: int, kappa: float) -> None:
    """Force over the sum of 1 / (|lambda|^kappa + epsilon), moment over the weighted moment of inertia."""
    config = WEIGHTED.model_copy(update={"kappa": kappa, "gamma_M": 0.7})
    segments = segments_by_hopping(room(Pose2D(), 0.01, seed), HoppingConfig())
    w = room(Pose2D(0.03, -0.02, 0.02), 0.01, seed + 1)[::5]
    lines = _lines(segments)
    along = lines[:, 3:5] @ w.T - lines[:, 5:6]
    offset = lines[:, 2:3] - lines[:, :2] @ w.T
    weights = ((along >= 0) & (along <= lines[:, 6:])) / (np.abs(offset) ** kappa + config.epsilon)
    weight, inertia = weights.sum(), (weights * np.sum((w - w.mean(axis=0)) ** 2, axis=1)).sum()
    pairs = len(segments) * len(w) / config.gamma_f
    f_printed, M_printed = printed_correction(w, segments, config)
    x, y = np.ascontiguousarray(w.T)
    fx, fy, M = _weighted_correction(x, y, lines, _constants(config))
    np.testing.assert_allclose([fx, fy], f_printed * pairs / weight, rtol=1e-9, atol=1e-15)
    assert M == pytest.approx(M_printed * pairs / inertia, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("moved", [Pose2D(0.2, -0.15, 0.12), Pose2D(-0.15, 0.2, -0.12), Pose2D(0.2, 0.2, 0.1)])
def test_a_large_displacement_is_composed_exactly(moved: Pose2D) -> None:
    """The sensor moved by T(dphi) dX; with dX alone, as eq. (19) adds it, these would come out 3 cm off."""
    match = match_points_to_segments(room(Pose2D()), segments_by_hopping(room(moved), HoppingConfig()), WEIGHTED)
    assert match.converged
    assert match.T_prior_laser.distance(moved) < 0.005
    assert abs(match.T_prior_laser.theta - moved.theta) < 0.003


@pytest.mark.parametrize("limit", [1, 7])
def test_the_iterations_end_at_their_limit(limit: int) -> None:
    segments = segments_by_hopping(room(Pose2D(0.05, 0.03, 0.02)), HoppingConfig())
    match = match_points_to_segments(room(Pose2D()), segments, CONFIG.model_copy(update={"max_iterations": limit}))
    assert (match.iterations, match.converged) == (limit, False)


@settings(max_examples=30)
@given(st.floats(-0.06, 0.06), st.floats(-0.06, 0.06), st.floats(-0.03, 0.03))
def test_a_small_displacement_is_found(dx: float, dy: float, dphi: float) -> None:
    moved = Pose2D(dx, dy, dphi)
    segments = segments_by_hopping(room(moved), HoppingConfig())
    match = match_points_to_segments(room(Pose2D()), segments, WEIGHTED)
    assert match.converged
    assert match.T_prior_laser.distance(moved) < 0.005
    assert abs(match.T_prior_laser.theta - dphi) < 0.002


@settings(max_examples=20)
@given(st.floats(-np.pi, np.pi))
def test_the_match_is_invariant_under_turned_sensor_axes(angle: float) -> None:
    segments = segments_by_hopping(room(Pose2D(0.03, 0.02, 0.01)), HoppingConfig())
    points, turn = room(Pose2D()), Pose2D(theta=angle)
    plain = match_points_to_segments(points, segments, CONFIG).T_prior_laser
    turned = match_points_to_segments(turn.transform(points), segments.transformed(turn), CONFIG).T_prior_laser
    expected = turn @ plain @ turn.inverse()
    assert turned.distance(expected) < 1e-6
    assert turned.theta == pytest.approx(expected.theta, abs=1e-6)


def test_points_on_their_segments_stay() -> None:
    points = room(Pose2D())
    match = match_points_to_segments(points, segments_by_hopping(points, HoppingConfig()), WEIGHTED)
    assert match.converged
    assert match.T_prior_laser.distance(Pose2D()) < 5e-4
    assert abs(match.T_prior_laser.theta) < 1e-3


def test_a_bare_wall_does_not_change_the_motion_along_it() -> None:
    wall = np.column_stack([np.linspace(-1, 1, 60), np.full(60, 1.0)])
    segments = segments_by_hopping(wall, HoppingConfig())
    shifted = Pose2D(y=0.02).transform(wall[10:50])  # within the wall, so that no point loses its segment
    T_prior_laser = match_points_to_segments(shifted, segments, WEIGHTED).T_prior_laser
    assert abs(T_prior_laser.x) < 1e-6
    assert T_prior_laser.y == pytest.approx(0.02, abs=1e-4)


def test_with_the_printed_gains_the_update_is_plain_descent() -> None:
    """With xi = 1 - zeta and eta = 1, eqs. (34) and (35), begun at rest, give dX = -sum f, whatever zeta is."""
    segments = segments_by_hopping(room(Pose2D(0.04, 0.02, 0.01)), HoppingConfig())
    printed = match_points_to_segments(room(Pose2D()), segments, CONFIG)
    plain = match_points_to_segments(room(Pose2D()), segments, CONFIG.model_copy(update={"xi": 1.0, "zeta": 0.0}))
    assert printed.iterations == plain.iterations
    assert printed.T_prior_laser.distance(plain.T_prior_laser) < 1e-12


def test_the_force_peaks_at_its_known_distance() -> None:
    """Fig. 10: the force of one segment on one point, largest at |lambda| = (epsilon / 2)^(1/3)."""
    wall = segments_by_hopping(np.column_stack([np.linspace(-1, 1, 60), np.full(60, 1.0)]), HoppingConfig())
    offsets, constants = np.linspace(0.001, 0.2, 400), _constants(ForceFieldConfig())
    forces = [hypot(*_correction(np.zeros(1), np.array([1.0 - d]), _lines(wall), constants)[:2]) for d in offsets]
    assert offsets[int(np.argmax(forces))] == pytest.approx((1e-4 / 2) ** (1 / 3), abs=0.001)


def test_without_matches_the_prior_is_kept() -> None:
    segments = segments_by_hopping(room(Pose2D()), HoppingConfig())
    assert match_points_to_segments(np.empty((0, 2)), segments, CONFIG) is NO_MATCH
    assert (
        match_points_to_segments(room(Pose2D()), segments_by_hopping(np.empty((0, 2)), HoppingConfig()), CONFIG)
        is NO_MATCH
    )
