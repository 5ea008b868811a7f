"""The uncertainty of the open submaps: a pose inherits that of the submap that it was matched to."""

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D


class SubmapUncertainty:
    """Covariances (3, 3) of the open submaps, x, y, theta where each began."""

    def __init__(self, first: FloatArray) -> None:
        self._open: list[tuple[Pose2D, FloatArray]] = [(Pose2D(), first)]  # scans are matched to the first, the oldest
        self._last: tuple[Pose2D, FloatArray] = Pose2D(), np.zeros((3, 3))

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Covariance (3, 3) of a pose, for that against the submap."""
        began, covariance = self._open[0]
        self._last = pose, propagate(covariance, began, pose) + match_covariance
        return self._last[1]

    def open_next(self, most: int) -> None:
        """Another submap begins at the last pose, and is known as well as that; so many stay open.

        Its many scans do not make it surer: their errors are alike, those of the walls that all of them saw.
        """
        self._open = [*self._open, self._last][-most:]

    def know(self, pose: Pose2D, covariance: FloatArray) -> None:
        """Take note of the covariance (3, 3) with which the submap that scans are matched to is known in ``local``.

        It is known so since a loop was closed.
        """
        self._open[0] = pose, covariance
