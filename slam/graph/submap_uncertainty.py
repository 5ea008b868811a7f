"""The uncertainty of the open submaps: a pose inherits that of the submap that it was matched to."""

from typing import Final

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D

NEW_SHARE: Final = 0.3
"""Of the variance of one match, what a submap has more than the one before: it is made by many scans, whose errors
average."""


class SubmapUncertainty:
    """Covariances (3, 3) of the open submaps, x, y, theta where each began."""

    def __init__(self, first: FloatArray) -> None:
        self._open: list[tuple[Pose2D, FloatArray]] = [(Pose2D(), first)]  # scans are matched to the first, the oldest
        self._last: tuple[Pose2D, FloatArray] = Pose2D(), np.zeros((3, 3))

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Covariance (3, 3) of a pose, for that against the submap."""
        self._last = pose, match_covariance
        began, covariance = self._open[0]
        return propagate(covariance, began, pose) + match_covariance

    def open_next(self, most: int) -> None:
        """Another submap begins at the last pose; so many stay open."""
        pose, match_covariance = self._last
        began, covariance = self._open[0]
        following = pose, propagate(covariance, began, pose) + NEW_SHARE * match_covariance
        self._open = [*self._open, following][-most:]

    def know(self, pose: Pose2D, covariance: FloatArray) -> None:
        """The pose (local) of the submap that scans are matched to is known with this covariance (3, 3) since a loop
        was closed."""
        self._open[0] = pose, covariance
