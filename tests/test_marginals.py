"""Covariances of the poses of a graph."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.graph.marginals import pose_covariances
from slam.graph.pose_graph import NO_LOOP, Edges, linear_system, solve_graph
from slam.pose import FloatArray, compose_poses, relative_poses, wrap_angles


def truth_of(count: int, seed: int) -> FloatArray:
    """A walk of steps of a metre in random directions."""
    random, poses = np.random.default_rng(seed), [np.zeros(3)]
    for _ in range(count - 1):
        motion = np.array([1.0, 0.0, random.normal(0.0, 0.4)])
        poses.append(compose_poses(poses[-1], motion[None])[0])
    return np.array(poses)


def edges_of(truth: FloatArray, loops: int, seed: int, noisy: bool) -> Edges:
    """Edges of a chain and ``loops`` loops; noise is drawn with the covariances whose inverses are the information."""
    random = np.random.default_rng(seed)
    count = len(truth)
    pairs = [(k, k + 1) for k in range(count - 1)] + [
        tuple(sorted(random.choice(count, 2, False))) for _ in range(loops)
    ]
    first, second = np.array(pairs, np.int64).T
    information = np.empty((len(pairs), 3, 3))
    measured = relative_poses(truth[first], truth[second])
    for k in range(len(pairs)):
        A = random.normal(size=(3, 3)) * np.array([0.02, 0.02, 0.005])[:, None]
        covariance = A @ A.T + np.diag([0.01, 0.01, 0.004]) ** 2
        information[k] = np.linalg.inv(covariance)
        if noisy:
            measured[k] += random.multivariate_normal(np.zeros(3), covariance)
    return Edges(first, second, measured, information, np.full(len(pairs), NO_LOOP))


@pytest.mark.parametrize(("count", "loops"), [(2, 0), (3, 1), (40, 0), (60, 12), (25, 80), (100, 150)])
def test_the_blocks_are_those_of_the_dense_inverse(count: int, loops: int) -> None:
    truth = truth_of(count, 1)
    edges = edges_of(truth, loops, 2, noisy=False)
    weights = np.random.default_rng(3).uniform(0.5, 1.0, len(edges.first))
    inverse = np.linalg.inv(linear_system(truth, edges, weights)[0].toarray()[3:, 3:])
    found = pose_covariances(truth, edges, weights)
    for k in range(1, count):
        assert found[k] == pytest.approx(inverse[3 * k - 3 : 3 * k, 3 * k - 3 : 3 * k], rel=1e-6, abs=1e-12)
    assert not found[0].any()


def test_a_graph_of_one_node_is_known() -> None:
    empty = np.empty(0, np.int64)
    edges = Edges(empty, empty, np.empty((0, 3)), np.empty((0, 3, 3)), empty)
    assert pose_covariances(np.ones((1, 3)), edges, np.empty(0)).tolist() == np.zeros((1, 3, 3)).tolist()


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), st.floats(-3.0, 3.0))
@settings(max_examples=10, deadline=None)
def test_covariances_turn_with_the_map(x: float, y: float, turn: float) -> None:
    truth = truth_of(20, 4)
    edges = edges_of(truth, 5, 5, noisy=False)
    weights = np.ones(len(edges.first))
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = pose_covariances(compose_poses(np.array([x, y, turn]), truth), edges, weights)
    assert moved == pytest.approx(R @ pose_covariances(truth, edges, weights) @ R.T, rel=1e-6, abs=1e-10)


def test_the_order_of_the_nodes_makes_no_difference() -> None:
    truth = truth_of(30, 6)
    edges = edges_of(truth, 8, 7, noisy=False)
    weights, order = np.ones(len(edges.first)), np.concatenate([[0], 1 + np.random.default_rng(8).permutation(29)])
    number = np.argsort(order)
    found = pose_covariances(
        truth[order], edges._replace(first=number[edges.first], second=number[edges.second]), weights
    )
    assert found == pytest.approx(pose_covariances(truth, edges, weights)[order], rel=1e-6, abs=1e-12)


def test_pose_errors_fit_their_covariances() -> None:
    """Squared normalized errors have the mean of a chi-square distribution with three degrees of freedom."""
    squares = []
    for seed in range(50):
        truth = truth_of(30, seed)
        edges = edges_of(truth, 5, 100 + seed, noisy=True)
        poses = solve_graph(truth, edges, 30.0).poses
        covariances = pose_covariances(poses, edges, np.ones(len(edges.first)))
        off = (poses - truth)[1:]
        off[:, 2] = wrap_angles(off[:, 2])
        squares.append(np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariances[1:]), off))
    assert np.mean(squares) == pytest.approx(3.0, rel=0.2)
