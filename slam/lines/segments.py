"""Line segments, as the paper stores them: S_m = {P_m, Q_m, theta_m, rho_m} (Proc. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slam.lines.range_noise import RangeNoise
from slam.pose import FloatArray, Pose2D

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """M segments as a structure of arrays; metres and radians, all in one frame.

    The line of segment m is the set of (x, y) with ``x cos(theta) + y sin(theta) = rho``, eq. (2). ``start`` and
    ``end`` are the measured points p_k(P_m) and p_k(Q_m), or lie on the line where there is a covariance; ``first`` and
    ``last`` are the places (from 0) of P_m and Q_m among the points of the scan.
    """

    first: IntArray  # (M,)
    last: IntArray  # (M,)
    rho: FloatArray  # (M,)
    theta: FloatArray  # (M,)
    start: FloatArray  # (M, 2)
    end: FloatArray  # (M, 2)
    covariance: FloatArray | None = None  # (M, 2, 2) of [rho, theta]; None where the method does not give it
    start_covariance: FloatArray | None = None  # (M, 2, 2) of [x, y]
    end_covariance: FloatArray | None = None  # (M, 2, 2)
    noise: RangeNoise | None = None  # of the ranges they were fitted to, where the method asks for it

    def __len__(self) -> int:
        return len(self.rho)

    @property
    def normals(self) -> FloatArray:
        """Unit normals e_n, shape (M, 2): eq. (25)."""
        return np.column_stack([np.cos(self.theta), np.sin(self.theta)])

    @property
    def counts(self) -> IntArray:
        """Points on each segment, shape (M,): Proc. 7, whose sign slip is mended here."""
        return self.last - self.first + 1

    def transformed(self, T_a_b: Pose2D) -> Segments:
        """Return the segments, given in frame ``b``, in frame ``a``."""
        theta = self.theta + T_a_b.theta
        shift = T_a_b.x * np.cos(theta) + T_a_b.y * np.sin(theta)
        turn = T_a_b.y * np.cos(theta) - T_a_b.x * np.sin(theta)
        jacobian = np.tile(np.eye(2), (len(theta), 1, 1))  # of (rho, theta) in a by those in b
        jacobian[:, 0, 1] = turn  # where the angle is unsure, so is how far the shift moves the line
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
    """Compute J C J^T of every covariance C (M, 2, 2), for one J (2, 2) or as many."""
    return None if covariance is None else jacobian @ covariance @ jacobian.swapaxes(-1, -2)
