"""The uncertainty of the open submaps: a pose inherits that of the submap that it was matched to."""

import numpy as np

from slam.motion_model import propagate
from slam.pose import FloatArray, Pose2D


class SubmapUncertainty:
    """Covariances (3, 3) of the open submaps, x, y, theta at their starts."""

    def __init__(self, first: FloatArray) -> None:
        self._open: list[tuple[Pose2D, FloatArray]] = [(Pose2D(), first)]  # scans are matched to the first, the oldest
        self._last: tuple[Pose2D, FloatArray] = Pose2D(), np.zeros((3, 3))

    def pose_covariance(self, pose: Pose2D, match_covariance: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of a pose; ``match_covariance`` is that of the match to the submap."""
        began, covariance = self._open[0]
        self._last = pose, propagate(covariance, began, pose) + match_covariance
        return self._last[1]

    def open_next(self, most: int) -> None:
        """Begin a submap at the last pose, with its covariance; at most ``most`` submaps stay open.

        The many scans of a submap do not reduce its covariance: their errors are correlated, as all saw the same walls.
        """
        self._open = [*self._open, self._last][-most:]

    def set_covariance(self, pose: Pose2D, covariance: FloatArray) -> None:
        """Set the pose and covariance (3, 3) of the submap that scans are matched to, as a closed loop gave them."""
        self._open[0] = pose, covariance
