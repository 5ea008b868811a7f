"""What is shown of one scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slam.deskew import deskewed
from slam.lines.segments import Segments
from slam.pose import FloatArray, Pose2D
from slam.run.step import Step
from slam.run.viewer.palette import NO_SEGMENT, Colour, wall_colours

_NO_ENDS = np.empty((0, 2, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One scan, the poses at it and what the method made of it; map frame, metres, radians, seconds."""

    index: int
    stamp: float
    slam: Pose2D | None
    """``T_map_base`` as estimated; None where nothing is estimated, ..."""
    odometry: Pose2D
    """... as dead reckoning has it ..."""
    truth: Pose2D | None
    """... and as it was, where that is known."""
    points: FloatArray
    """(N, 2): where the beams ended that came back ..."""
    point_colours: Colour
    """... and the colour of the segment that each belongs to, (N,)."""
    ends: FloatArray
    """(M, 2, 2): [segment, start or end, x or y]."""
    end_colours: Colour
    """(M,)."""
    covariance: FloatArray | None = None
    """(3, 3) of x, y, theta."""
    unconstrained: FloatArray | None = None
    """(K, 3), see Match."""
    iterations: int = 0
    extraction_time: float = 0.0
    total_time: float = 0.0
    command: tuple[float, float] = (0.0, 0.0)
    """m/s and rad/s, as applied."""

    @property
    def robot(self) -> Pose2D:
        """Where the robot is drawn: where it is thought to be, or is."""
        return self.slam or self.truth or self.odometry


def frame_of(step: Step, T_map_odom: Pose2D, T_base_laser: Pose2D, deskew: bool) -> Frame:
    """What is shown of a step; the scan is mended as the method mends it."""
    estimate, scan, odometry = step.estimate, step.observation.scan, step.observation.odometry
    if deskew:
        scan = deskewed(scan, odometry.twist, T_base_laser)
    T_map_laser = estimate.T_map_base @ T_base_laser
    points = scan.points()
    colours, ends, end_colours = coloured(points, estimate.segments, T_map_laser)
    return Frame(
        step.index,
        estimate.stamp,
        estimate.T_map_base,
        T_map_odom @ odometry.T_odom_base,
        step.observation.T_map_base,
        T_map_laser.transform(points),
        colours,
        ends,
        end_colours,
        estimate.covariance,
        estimate.unconstrained,
        estimate.match.iterations,
        estimate.extraction_time,
        estimate.total_time,
        (step.applied.linear, step.applied.angular),
    )


def coloured(points: FloatArray, segments: Segments | None, T_map_laser: Pose2D) -> tuple[Colour, FloatArray, Colour]:
    """The colour of each point (N,), and the segments of a scan in the map frame, (M, 2, 2), with their colours."""
    colours = np.full(len(points), NO_SEGMENT, np.uint32)
    if segments is None:
        return colours, _NO_ENDS, colours[:0]
    own = wall_colours(segments.theta + T_map_laser.theta)
    for first, last, colour in zip(segments.first.tolist(), segments.last.tolist(), own.tolist(), strict=True):
        colours[first : last + 1] = colour
    ends = T_map_laser.transform(np.stack([segments.start, segments.end], axis=1).reshape(-1, 2))
    return colours, ends.reshape(-1, 2, 2), own
