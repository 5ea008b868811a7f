"""The result of matching a scan to the map, whatever the method."""

from dataclasses import dataclass, replace
from math import cos, sin
from typing import Self

import numpy as np

from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Outcome of one matching: ``T_prior_laser`` is the sensor's pose relative to its prior pose."""

    T_prior_laser: Pose2D
    iterations: int
    converged: bool
    points: int
    """Number of matched items: map points N* of the paper's matcher, pieces of the scan of the project's own."""
    inliers: float = 0.0
    """Weighted number of those that agree with the map."""
    covariance: FloatArray | None = None
    """Covariance (3, 3) of the base's x, y, theta in the map; m^2, m rad, rad^2; None if the method has none."""
    unconstrained: FloatArray | None = None
    """Unit directions (K, 3) in which the scan did not constrain the pose, so that the prior decides; of x, y and theta
    times a lever, map frame; None if the method has none."""
    searched: bool = False
    """True if the coarse search was used."""
    lost: bool = False
    """True if the last scans did not fit the map."""
    odometry_only: bool = False
    """True if the result was rejected, and the pose is the prediction of odometry."""

    def turned(self, angle: float) -> Self:
        """Return the match with covariance and directions rotated by this angle, radians."""
        if angle == 0.0:
            return self
        c, s = cos(angle), sin(angle)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        covariance = None if self.covariance is None else R @ self.covariance @ R.T
        unconstrained = None if self.unconstrained is None else self.unconstrained @ R.T
        return replace(self, covariance=covariance, unconstrained=unconstrained)


NO_MATCH = Match(Pose2D(), iterations=0, converged=False, points=0)
"""Result without anything to match: the prior."""
