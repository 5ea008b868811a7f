"""The pose graph: its laws, a ring with known answer, and the compiled sums against a plain reference."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.graph.pose_graph import Edge, Edges, linear_system, robust_weights, solve_graph, squared_errors
from slam.graph.single_poses import between, composed, composed_with_inverse
from slam.pose import FloatArray, compose_poses, inverse_poses, relative_poses, wrap_angle

KERNEL = 30.0
INFORMATION = np.diag([1e4, 8e3, 1e5])
"""Information of edges with errors of about a centimetre and three milliradians."""
NOISE = 0.01, 0.01, 0.003
POSE = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1)).map(np.array)


def ring(count: int = 40) -> FloatArray:
    """Poses around a circle, heading along it."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([10.0 * np.sin(angles), 10.0 - 10.0 * np.cos(angles), angles])


def chain(poses: FloatArray, noise: FloatArray) -> list[Edge]:
    moved = relative_poses(poses[:-1], poses[1:]) + noise
    return [Edge(k, k + 1, motion, INFORMATION) for k, motion in enumerate(moved)]


def start(edges: list[Edge], count: int) -> FloatArray:
    poses = np.zeros((count, 3))
    for edge in edges[: count - 1]:
        poses[edge.second] = composed(poses[edge.first], edge.measured)
    return poses


def loop_at(poses: FloatArray, first: int, second: int, number: int, off: tuple[float, float, float]) -> Edge:
    return Edge(first, second, relative_poses(poses[first], poses[second]) + np.array(off), INFORMATION, number)


@given(POSE, POSE)
def test_single_poses_are_composed_as_arrays_of_poses_are(a: FloatArray, b: FloatArray) -> None:
    for found, expected in (
        (composed(a, b), compose_poses(a, b)),
        (between(a, b), relative_poses(a, b)),
        (composed_with_inverse(a, b), compose_poses(a, inverse_poses(b))),
    ):
        assert np.abs(found[:2] - expected[:2]).max() < 1e-9
        assert abs(wrap_angle(float(found[2] - expected[2]))) < 1e-9


def test_without_noise_the_truth_is_found() -> None:
    truth = ring()
    edges = Edges.of([*chain(truth, np.zeros((39, 3))), loop_at(truth, 0, 39, 0, (0, 0, 0))])
    found = solve_graph(truth + np.vstack([np.zeros(3), np.full((39, 3), 0.05)]), edges, KERNEL).poses
    np.testing.assert_allclose(relative_poses(truth, found), 0.0, atol=1e-6)


@settings(max_examples=10, deadline=None)
@given(POSE)
def test_the_frame_of_the_map_does_not_matter(moved: FloatArray) -> None:
    truth, noise = ring(), np.random.default_rng(1).normal(0.0, NOISE, (39, 3))
    edges = Edges.of([*chain(truth, noise), loop_at(truth, 3, 38, 0, (0, 0, 0))])
    begin = start(chain(truth, noise), 40)
    here, there = (solve_graph(poses, edges, KERNEL).poses for poses in (begin, compose_poses(moved, begin)))
    np.testing.assert_allclose(relative_poses(compose_poses(moved, here), there), 0.0, atol=1e-5)


def test_a_loop_corrects_the_drift() -> None:
    truth, drift = ring(), np.tile([0.0, 0.0, 0.003], (39, 1))
    edges = chain(truth, drift)
    begin = start(edges, 40)
    assert np.hypot(*(begin[-1] - truth[-1])[:2]) > 0.5
    found = solve_graph(begin, Edges.of([*edges, loop_at(truth, 0, 39, 0, (0, 0, 0))]), KERNEL)
    assert np.hypot(*(found.poses[-1] - truth[-1])[:2]) < 0.05
    assert found.weights[-1] > 0.9


def test_wrong_loops_get_little_weight() -> None:
    truth, noise = ring(), np.random.default_rng(2).normal(0.0, NOISE, (39, 3))
    right = [loop_at(truth, k, 39 - k, k, (0, 0, 0)) for k in range(5)]
    wrong = [loop_at(truth, 10, 30, 5, (3.0, -2.0, 0.5)), loop_at(truth, 5, 25, 6, (0.0, 4.0, 0.0))]
    edges = Edges.of([*chain(truth, noise), *right, *wrong])
    found = solve_graph(start(chain(truth, noise), 40), edges, KERNEL)
    assert (found.weights[39:44] > 0.8).all()
    assert (found.weights[44:] < 0.05).all()
    assert np.hypot(*(found.poses - truth)[:, :2].T).max() < 0.15


@pytest.mark.parametrize("seed", range(3))
def test_the_system_is_the_derivative_of_the_sum(seed: int) -> None:
    """The expected values are finite differences of half the weighted sum of squares."""
    random = np.random.default_rng(seed)
    poses = random.normal(0.0, 2.0, (4, 3))
    edges = Edges.of(
        [Edge(a, b, random.normal(0.0, 1.0, 3), INFORMATION, 0) for a, b in ((0, 1), (1, 2), (3, 1), (2, 0))]
    )
    weights = random.random(4)
    H, gradient = linear_system(poses, edges, weights)
    step = 1e-6
    for k in range(12):
        ahead, back = poses.ravel().copy(), poses.ravel().copy()
        ahead[k] += step
        back[k] -= step
        sums = [0.5 * weights @ squared_errors(moved.reshape(4, 3), edges) for moved in (ahead, back)]
        assert gradient[k] == pytest.approx((sums[0] - sums[1]) / (2.0 * step), rel=1e-4, abs=1.0)
    np.testing.assert_allclose(H.toarray(), H.toarray().T, atol=1e-9)
    assert np.linalg.eigvalsh(H.toarray()).min() > -1e-6


def test_the_errors_are_those_of_the_plain_sum() -> None:
    random = np.random.default_rng(5)
    poses = random.normal(0.0, 2.0, (5, 3))
    edges = Edges.of([Edge(k, k + 1, random.normal(0.0, 1.0, 3), INFORMATION) for k in range(4)])
    expected = []
    for k in range(4):
        e = relative_poses(poses[k], poses[k + 1]) - edges.measured[k]
        e[2] = wrap_angle(float(e[2]))
        expected.append(e @ INFORMATION @ e)
    np.testing.assert_allclose(squared_errors(poses, edges), expected)


def test_only_loops_have_a_robust_weight() -> None:
    weights = robust_weights(np.array([1e6, 1e6, 0.0]), np.array([False, True, True]), KERNEL)
    assert weights[0] == 1.0
    assert weights[1] < 1e-6
    assert weights[2] == 1.0
