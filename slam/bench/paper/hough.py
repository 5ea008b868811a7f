"""The Hough transform that section 3.4 compares with: scikit-image's, on the scan drawn as a picture."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from slam.named_code import import_optional
from slam.pose import FloatArray

_CELL: Final = 0.01
"""Side of a pixel, metres."""
_ANGLES: Final = np.radians(np.arange(-90.0, 90.0, 1.0))
_NEIGHBOURS: Final = {"min_distance": 1, "min_angle": 1}
"""Of two peaks this near, in cells, one is kept. Wider suppression finds fewer doubles, and fewer true lines."""


@dataclass(frozen=True, slots=True, eq=False)
class HoughLines:
    """Lines x cos(theta) + y sin(theta) = rho in the frame of the points, and the votes they were found in."""

    rho: FloatArray  # (M,) metres
    theta: FloatArray  # (M,) radians
    share: float
    """Peaks have at least this share of the most votes."""
    votes: FloatArray  # (D, A)
    peak_distances: FloatArray  # (M,) metres: where the lines are among the votes
    distances: FloatArray  # (D,) metres from the corner of the picture
    angles: FloatArray  # (A,) radians


def hough_lines(points: FloatArray, share: float = 0.5) -> HoughLines:
    """The lines through points (N, 2), metres, that have ``share`` of the most votes; half of them is the usual."""
    transform = import_optional("skimage.transform", "bench")
    reach = np.abs(points).max(initial=_CELL)
    cells = np.floor((points + reach) / _CELL).astype(np.int64)
    picture = np.zeros(cells.max(axis=0, initial=0)[::-1] + 1, np.uint8)
    picture[cells[:, 1], cells[:, 0]] = 1
    votes, angles, distances = transform.hough_line(picture, theta=_ANGLES)
    _, theta, pixels = transform.hough_line_peaks(
        votes, angles, distances, threshold=share * votes.max(), num_peaks=np.inf, **_NEIGHBOURS
    )
    corner = 0.5 * _CELL - reach  # of the middle of the first pixel
    rho = _CELL * pixels + corner * (np.cos(theta) + np.sin(theta))
    return HoughLines(rho, theta, share, votes.astype(np.float64), _CELL * pixels, _CELL * distances, angles)
