"""The probabilistic Hough transform of OpenCV on the scan drawn as a picture (Matas et al. 2000)."""

from dataclasses import dataclass

import numpy as np

from slam.lines.segments import Segments
from slam.named_code import import_optional
from slam.pose import FloatArray
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class ProbabilisticHough:
    """Settings, lengths in metres; the defaults are tuned at the noise level ``spec/3`` of ``slam.bench.scenes``."""

    cell: float = 0.05
    """Side of a pixel, metres."""
    angle_step: float = np.pi / 90.0
    """Radians."""
    votes: int = 12
    min_length: float = 0.2
    max_gap: float = 0.3

    def __call__(self, scan: LaserScan) -> Segments:
        """Extract the segments of a scan, sensor frame."""
        cv2 = import_optional("cv2", "bench")
        points = scan.points()
        if not len(points):
            return _segments(points, np.empty((0, 2, 2)))
        corner = points.min(axis=0)
        pixels = np.floor((points - corner) / self.cell).astype(np.int64)
        picture = np.zeros(pixels.max(axis=0)[::-1] + 1, np.uint8)
        picture[pixels[:, 1], pixels[:, 0]] = 255
        cv2.setRNGSeed(0)
        found = cv2.HoughLinesP(
            picture, 1.0, self.angle_step, self.votes, None, self.min_length / self.cell, self.max_gap / self.cell
        )
        ends = np.empty((0, 2, 2)) if found is None else found.reshape(-1, 2, 2)
        return _segments(points, corner + self.cell * (ends + 0.5))


def _segments(points: FloatArray, ends: FloatArray) -> Segments:
    """Return segments with these ends (M, 2, 2); ``first`` and ``last`` index the points (N, 2) nearest to them."""
    nearest = np.array([[np.argmin(np.hypot(*(points - end).T)) for end in pair] for pair in ends], np.int64).reshape(
        -1, 2
    )
    swapped = nearest[:, 0] > nearest[:, 1]
    ends[swapped], nearest[swapped] = ends[swapped, ::-1], nearest[swapped, ::-1]
    along = ends[:, 1] - ends[:, 0]
    theta = np.arctan2(along[:, 0], -along[:, 1])
    rho = np.cos(theta) * ends[:, 0, 0] + np.sin(theta) * ends[:, 0, 1]
    theta = np.where(rho < 0.0, theta - np.sign(theta) * np.pi, theta)
    return Segments(nearest[:, 0], nearest[:, 1], np.abs(rho), theta, ends[:, 0], ends[:, 1])
