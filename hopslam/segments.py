"""The line segments of one scan."""

import numpy as np

from slam.lines.segments import Segments as FoundSegments
from slam.pose import FloatArray, Pose2D


class Segments:
    """M line segments in one frame, metres and radians; segments of a scan are in the sensor frame.

    Segment m lies on the line ``x cos(theta[m]) + y sin(theta[m]) = rho[m]``.
    """

    def __init__(self, found: FoundSegments, points: FloatArray) -> None:
        self._found, self._points = found, points

    @property
    def ends(self) -> FloatArray:
        """Start and end of each segment, (M, 2, 2): [segment, start or end, x or y]."""
        return np.stack([self._found.start, self._found.end], axis=1)

    @property
    def lengths(self) -> FloatArray:
        """Length of each segment, (M,), metres."""
        return np.asarray(np.hypot(*(self._found.end - self._found.start).T))

    @property
    def rho(self) -> FloatArray:
        """Distance of each line from the origin, metres, (M,)."""
        return self._found.rho

    @property
    def theta(self) -> FloatArray:
        """Direction of each line's normal, radians, (M,)."""
        return self._found.theta

    @property
    def covariance(self) -> FloatArray | None:
        """Covariance (M, 2, 2) of [rho, theta] of each segment; None if the method gives none, as in paper mode."""
        return self._found.covariance

    def moved(self, pose: Pose2D) -> "Segments":
        """Transform the segments by ``pose``: with the sensor's pose in the map, the result is in the map frame."""
        return Segments(self._found.transformed(pose), pose.transform(self._points))

    def __len__(self) -> int:
        return len(self._found)

    def __repr__(self) -> str:
        return f"Segments({len(self)}, {self.lengths.sum():.2f} m in all)"

    def picture(self) -> bytes:
        """Draw the segments in colours, with their points; return the content of a PNG file."""
        from slam.run.pictures.figure_style import png_of
        from slam.run.pictures.scan_picture import scan_figure

        return png_of(scan_figure(self._points, self._found, f"{len(self)} segments", inches=6.0))

    def _repr_png_(self) -> bytes:
        return self.picture()
