"""Matrices of three rows or so, for compiled code: plain loops, which compile and run faster than calls of LAPACK."""

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.pose import FloatArray

_SWEEPS = 6  # largest number of sweeps; three or four make the off-diagonal of a (3, 3) zero


@compiled
def identity() -> FloatArray:
    """Return the unit matrix (3, 3)."""
    one = np.zeros((3, 3))
    one[0, 0] = one[1, 1] = one[2, 2] = 1.0
    return one


@compiled
def product(A: FloatArray, B: FloatArray) -> FloatArray:
    """A B, for A (M, K) and B (K, N)."""
    C = np.zeros((len(A), B.shape[1]))
    for i in range(len(A)):
        for j in range(B.shape[1]):
            for k in range(len(B)):
                C[i, j] += A[i, k] * B[k, j]
    return C


@compiled_on_views
def write(C: FloatArray, A: FloatArray) -> None:
    """Copy A (3, 3) to C."""
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, j]


@compiled_on_views
def add(C: FloatArray, A: FloatArray) -> None:
    """Add A (3, 3) to C."""
    for i in range(3):
        for j in range(3):
            C[i, j] += A[i, j]


@compiled_on_views
def subtract_product(C: FloatArray, A: FloatArray, B: FloatArray) -> None:
    """Subtract A B (3, 3) from C; none of them shares memory with C."""
    for i in range(3):
        for j in range(3):
            C[i, j] -= A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@compiled
def times(A: FloatArray, x: FloatArray) -> FloatArray:
    """A x (M,), for A (M, 3) and x (3,)."""
    b = np.empty(len(A))
    for i in range(len(A)):
        b[i] = A[i, 0] * x[0] + A[i, 1] * x[1] + A[i, 2] * x[2]
    return b


@compiled
def solved(A: FloatArray, b: FloatArray) -> FloatArray:
    """Solve A x = b for x (3,), with A (3, 3) symmetric and positive definite."""
    m, p, q, n, r, o = _factor(A)
    x = np.empty(3)
    x[0] = b[0] / m
    x[1] = (b[1] - p * x[0]) / n
    x[2] = (b[2] - q * x[0] - r * x[1]) / (o * o)
    x[1] = (x[1] - r * x[2]) / n
    x[0] = (x[0] - p * x[1] - q * x[2]) / m
    return x


@compiled
def inverse(A: FloatArray) -> FloatArray:
    """A^-1 = M^-T M^-1 (3, 3), for A (3, 3) symmetric and positive definite; it is exactly symmetric."""
    m, p, q, n, r, o = _factor(A)
    v, w = -r / (n * o), -p / (m * n)  # below the diagonal of M^-1
    u = -(q / m + r * w) / o
    C = np.empty((3, 3))
    C[0, 0], C[1, 1], C[2, 2] = 1.0 / (m * m) + w * w + u * u, 1.0 / (n * n) + v * v, 1.0 / (o * o)
    C[0, 1] = C[1, 0] = w / n + u * v
    C[0, 2] = C[2, 0] = u / o
    C[1, 2] = C[2, 1] = v / o
    return C


@compiled_on_views
def _factor(A: FloatArray) -> tuple[float, float, float, float, float, float]:
    """Return m, p, q, n, r, o of A = M M^T with M = [[m, 0, 0], [p, n, 0], [q, r, o]]; A (3, 3) by its upper half."""
    m = np.sqrt(A[0, 0])
    p, q = A[0, 1] / m, A[0, 2] / m
    n = np.sqrt(A[1, 1] - p * p)
    r = (A[1, 2] - p * q) / n
    return m, p, q, n, r, np.sqrt(A[2, 2] - q * q - r * r)


@compiled
def principal_axes(A: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (3,) of a symmetric (3, 3), and its eigenvectors as columns (3, 3), in no order.

    Jacobi's rotations: each makes one number off the diagonal zero.
    """
    D, vectors = A.copy(), identity()
    for _ in range(_SWEEPS):
        for p in range(2):
            for q in range(p + 1, 3):
                if abs(D[p, q]) > 1e-100 * abs(D[q, q] - D[p, p]):  # not if half^2 overflows
                    half = 0.5 * (D[q, q] - D[p, p]) / D[p, q]
                    tangent = 1.0 / (half + np.copysign(np.sqrt(half * half + 1.0), half))
                    c = 1.0 / np.sqrt(tangent * tangent + 1.0)
                    _turn(D, p, q, c, c * tangent)
                    _turn(D.T, p, q, c, c * tangent)
                    _turn(vectors, p, q, c, c * tangent)
    values = np.empty(3)
    for k in range(3):
        values[k] = D[k, k]
    return values, vectors


@compiled_on_views
def _turn(columns: FloatArray, p: int, q: int, c: float, s: float) -> None:
    """Rotate two of three columns in their plane."""
    for k in range(3):
        x, y = columns[k, p], columns[k, q]
        columns[k, p], columns[k, q] = c * x - s * y, s * x + c * y
