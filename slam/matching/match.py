"""The result of matching a scan to the map, whatever the method."""

from dataclasses import dataclass, replace
from math import cos, sin
from typing import Self

import numpy as np

from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """The outcome of one matching: ``T_prior_laser`` is the sensor's pose as seen from where it was thought to be."""

    T_prior_laser: Pose2D
    iterations: int
    converged: bool
    points: int
    """Number that took part: map points N* of the paper's matcher, pieces of the scan of the project's own."""
    inliers: float = 0.0
    """Those of them that agree with the map, each by its weight."""
    covariance: FloatArray | None = None
    """Covariance (3, 3) of the base's x, y, theta in the map; m^2, m rad, rad^2; None where the method gives none."""
    unconstrained: FloatArray | None = None
    """Unit directions (K, 3) of x, y and lever times theta, map frame, in which the scan said nothing and the prior
    stands; None where the method does not tell."""
    searched: bool = False
    """True where the coarse search was used."""
    lost: bool = False
    """True where the last scans did not fit the map."""
    odometry_only: bool = False
    """True where the scan said nothing that could be trusted, and the pose is what odometry predicts."""

    def turned(self, angle: float) -> Self:
        """The same match, its covariance and directions in axes that are turned back by this angle, radians."""
        if angle == 0.0:
            return self
        c, s = cos(angle), sin(angle)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        covariance = None if self.covariance is None else R @ self.covariance @ R.T
        unconstrained = None if self.unconstrained is None else self.unconstrained @ R.T
        return replace(self, covariance=covariance, unconstrained=unconstrained)


NO_MATCH = Match(Pose2D(), iterations=0, converged=False, points=0)
"""Nothing to match: the prior stands."""
