"""What a viewer is told of a run before it begins."""

from __future__ import annotations

from dataclasses import dataclass

from slam.pose import FloatArray, Pose2D
from slam.run.estimator import Estimator
from slam.run.viewer.curves import PLOTS

_ORIGIN = Pose2D()


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Map frame, metres."""

    T_base_laser: Pose2D
    T_map_odom: Pose2D = _ORIGIN
    """Where dead reckoning begins."""
    slam: Estimator | None = None
    """Whose map is shown as it grows."""
    deskew: bool = False
    """Whether the method mends the skew of the scans."""
    outlines: tuple[FloatArray, ...] = ()
    """Of what the lidar can see of the true world: closed polygons (V, 2)."""
    route: FloatArray | None = None
    """Way-points (W, 2), from the start on."""
    around: FloatArray | None = None
    """More points (N, 2) that the eye should see."""
    plots: tuple[str, ...] = tuple(PLOTS)
    """Which of the curves there are."""
