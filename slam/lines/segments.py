"""Line segments, as the paper stores them: S_m = {P_m, Q_m, theta_m, rho_m} (Proc. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray, Pose2D

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """M segments as a structure of arrays; metres and radians, all in one frame.

    The line of segment m is the set of (x, y) with ``x cos(theta) + y sin(theta) = rho``, eq. (2). ``start`` and
    ``end`` are the measured points p_k(P_m) and p_k(Q_m); ``first`` and ``last`` are their places (from 0) among the
    points of the scan.
    """

    first: IntArray  # (M,)
    last: IntArray  # (M,)
    rho: FloatArray  # (M,)
    theta: FloatArray  # (M,)
    start: FloatArray  # (M, 2)
    end: FloatArray  # (M, 2)

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
        """The segments, given in frame ``b``, in frame ``a``."""
        theta = self.theta + T_a_b.theta
        rho = self.rho + T_a_b.x * np.cos(theta) + T_a_b.y * np.sin(theta)
        return Segments(self.first, self.last, rho, theta, T_a_b.transform(self.start), T_a_b.transform(self.end))
