"""Line segments, as the paper stores them: S_m = {P_m, Q_m, theta_m, rho_m} (Proc. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slam.lines.range_noise import RangeNoise
from slam.pose import FloatArray, Pose2D, unit_vectors

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """M segments as a structure of arrays; metres and radians, all in one frame.

    The line of segment m is the set of (x, y) with ``x cos(theta) + y sin(theta) = rho``, eq. (2). ``start`` and
    ``end`` are the measured points p_k(P_m) and p_k(Q_m), or, with a covariance, points on the line; ``first`` and
    ``last`` are the indices (from 0) of P_m and Q_m among the points of the scan.
    """

    first: IntArray  # (M,)
    last: IntArray  # (M,)
    rho: FloatArray  # (M,)
    theta: FloatArray  # (M,)
    start: FloatArray  # (M, 2)
    end: FloatArray  # (M, 2)
    covariance: FloatArray | None = None  # (M, 2, 2) of [rho, theta]; None if the method has none
    start_covariance: FloatArray | None = None  # (M, 2, 2) of [x, y]
    end_covariance: FloatArray | None = None  # (M, 2, 2)
    noise: RangeNoise | None = None  # noise of the ranges, if the method uses it

    def __len__(self) -> int:
        return len(self.rho)

    @property
    def normals(self) -> FloatArray:
        """Unit normals e_n, shape (M, 2): eq. (25)."""
        return unit_vectors(self.theta)

    @property
    def counts(self) -> IntArray:
        """Number of points on each segment, shape (M,): Proc. 7, with its sign corrected."""
        return self.last - self.first + 1

    def transformed(self, T_a_b: Pose2D) -> Segments:
        """Return the segments, given in frame ``b``, in frame ``a``."""
        theta = self.theta + T_a_b.theta
        shift = T_a_b.x * np.cos(theta) + T_a_b.y * np.sin(theta)
        turn = T_a_b.y * np.cos(theta) - T_a_b.x * np.sin(theta)
        jacobian = np.tile(np.eye(2), (len(theta), 1, 1))  # derivative of (rho, theta) in a with respect to those in b
        jacobian[:, 0, 1] = turn  # the uncertainty of the angle makes the shift of the line uncertain
        return Segments(
            self.first,
            self.last,
            self.rho + shift,
            theta,
            T_a_b.transform(self.start),
            T_a_b.transform(self.end),
            _propagated(jacobian, self.covariance),
            _propagated(T_a_b.rotation, self.start_covariance),
            _propagated(T_a_b.rotation, self.end_covariance),
        )


def _propagated(jacobian: FloatArray, covariance: FloatArray | None) -> FloatArray | None:
    """Compute J C J^T of every covariance C (M, 2, 2), for one J (2, 2) or one for each."""
    return None if covariance is None else jacobian @ covariance @ jacobian.swapaxes(-1, -2)
