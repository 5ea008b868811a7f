"""Single poses as arrays (3,), compiled: numpy has too much overhead for so few numbers."""

import numpy as np

from slam.compiled import compiled, wrapped
from slam.pose import FloatArray


@compiled
def composed(T_a_b: FloatArray, T_b_c: FloatArray) -> FloatArray:
    """Compose two poses: ``T_a_c`` (3,)."""
    c, s = np.cos(T_a_b[2]), np.sin(T_a_b[2])
    x, y = T_a_b[0] + c * T_b_c[0] - s * T_b_c[1], T_a_b[1] + s * T_b_c[0] + c * T_b_c[1]
    return np.array([x, y, wrapped(T_a_b[2] + T_b_c[2])])


@compiled
def between(T_a_b: FloatArray, T_a_c: FloatArray) -> FloatArray:
    """Return ``T_b_c`` (3,) of two poses given in one frame."""
    c, s = np.cos(T_a_b[2]), np.sin(T_a_b[2])
    dx, dy = T_a_c[0] - T_a_b[0], T_a_c[1] - T_a_b[1]
    return np.array([c * dx + s * dy, c * dy - s * dx, wrapped(T_a_c[2] - T_a_b[2])])


@compiled
def composed_with_inverse(T_a_b: FloatArray, T_c_b: FloatArray) -> FloatArray:
    """Return ``T_a_c`` (3,) from the poses of ``b`` in ``a`` and in ``c``: T_a_b @ T_c_b^-1."""
    turn = T_a_b[2] - T_c_b[2]
    c, s = np.cos(turn), np.sin(turn)
    return np.array([T_a_b[0] - c * T_c_b[0] + s * T_c_b[1], T_a_b[1] - s * T_c_b[0] - c * T_c_b[1], wrapped(turn)])
