"""Small matrices in compiled code, against numpy's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.pose import FloatArray
from slam.small_matrices import inverse, principal_axes, product, solved, subtract_product, times

SEEDS = st.integers(0, 2**32 - 1)
EXACT = 1e-14


def covariance_of(seed: int) -> FloatArray:
    """A positive definite (3, 3) whose axes differ by some orders of magnitude, as those of a corridor do."""
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return np.asarray(turn @ np.diag(10.0 ** random.uniform(-4.0, 4.0, 3)) @ turn.T)


@given(SEEDS)
@settings(max_examples=50, deadline=None)
def test_inverse_and_solution_are_those_of_numpy(seed: int) -> None:
    A, b = covariance_of(seed), np.random.default_rng(seed).normal(size=3)
    allowed = EXACT * np.linalg.cond(A)
    assert inverse(A) @ A == pytest.approx(np.eye(3), abs=allowed)
    assert np.array_equal(inverse(A), inverse(A).T)
    assert solved(A, b) == pytest.approx(np.linalg.solve(A, b), rel=1e-9, abs=allowed * np.abs(b / A.max()).max())


@given(SEEDS)
@settings(max_examples=50, deadline=None)
def test_principal_axes_are_orthonormal_and_give_the_matrix(seed: int) -> None:
    random = np.random.default_rng(seed)
    half = random.normal(size=(3, 3)) * 10.0 ** random.uniform(-4.0, 4.0, (3, 1))
    A = half + half.T
    values, axes = principal_axes(A)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=EXACT)
    assert axes @ np.diag(values) @ axes.T == pytest.approx(A, abs=EXACT * np.abs(A).max())
    assert np.sort(values) == pytest.approx(np.linalg.eigvalsh(A), abs=EXACT * np.abs(A).max())


@pytest.mark.parametrize("A", [np.eye(3), np.zeros((3, 3)), np.ones((3, 3)), np.diag([2.0, 2.0, 0.0])])
def test_principal_axes_of_equal_values_are_orthonormal_too(A: FloatArray) -> None:
    values, axes = principal_axes(A)
    assert axes @ np.diag(values) @ axes.T == pytest.approx(A, abs=EXACT)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=EXACT)


def test_products_are_those_of_numpy() -> None:
    random = np.random.default_rng(0)
    A, B, C = random.normal(size=(6, 3)), random.normal(size=(3, 4)), random.normal(size=(3, 3))
    x = random.normal(size=3)
    assert product(A, B) == pytest.approx(A @ B, abs=EXACT)
    assert times(A, x) == pytest.approx(A @ x, abs=EXACT)
    left = np.ones((3, 3))
    subtract_product(left, A[:3], C.T)
    assert left == pytest.approx(1.0 - A[:3] @ C.T, abs=EXACT)
