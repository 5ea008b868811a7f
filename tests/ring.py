"""A corridor around a block with niches, in which the tests of loops drive."""

import numpy as np

from slam.pose import FloatArray, Pose2D

OUTER = np.array([
    [-2.0, -2.0], [3.0, -2.0], [3.0, -2.6], [4.0, -2.6], [4.0, -2.0], [9.0, -2.0], [9.0, -1.6], [10.5, -1.6],
    [10.5, -2.0], [14.0, -2.0], [14.0, 2.0], [14.7, 2.0], [14.7, 3.2], [14.0, 3.2], [14.0, 10.0], [8.0, 10.0],
    [8.0, 9.5], [6.5, 9.5], [6.5, 10.0], [-2.0, 10.0], [-2.0, 6.0], [-2.6, 6.0], [-2.6, 4.5], [-2.0, 4.5], [-2.0, -2.0],
])  # fmt: skip
INNER = np.array([
    [1.0, 1.0], [1.0, 4.0], [1.8, 4.0], [1.8, 5.0], [1.0, 5.0], [1.0, 7.0], [3.0, 7.0], [3.0, 6.4], [4.2, 6.4],
    [4.2, 7.0], [11.0, 7.0], [11.0, 5.5], [10.3, 5.5], [10.3, 4.0], [11.0, 4.0], [11.0, 1.0], [7.0, 1.0], [7.0, 1.8],
    [5.5, 1.8], [5.5, 1.0], [1.0, 1.0],
])  # fmt: skip


def around(laps: float) -> list[Pose2D]:
    """Return poses every 0.2 m along the corridor between the two walls."""
    corners = np.array([[-0.5, -0.5], [12.5, -0.5], [12.5, 8.5], [-0.5, 8.5]])
    path, heading = [], 0.0
    for corner in range(int(4 * laps)):
        begin, end = corners[corner % 4], corners[(corner + 1) % 4]
        steps = int(np.hypot(*(end - begin)) / 0.2)
        path += [Pose2D.from_array(np.append(begin + k / steps * (end - begin), heading)) for k in range(steps)]
        path += [Pose2D.from_array(np.append(end, heading + 0.25 * np.pi * turn)) for turn in (0.5, 1.0, 1.5)]
        heading += 0.5 * np.pi
    return path


def ranges_from(pose: Pose2D, bearings: FloatArray) -> FloatArray:
    """Return the ranges of the beams to the nearest wall, metres."""
    walls = [np.stack([corners[:-1], corners[1:]], axis=1) for corners in (OUTER, INNER)]
    a, b = np.concatenate(walls).swapaxes(0, 1)
    angles = pose.theta + bearings
    d = np.column_stack([np.cos(angles), np.sin(angles)])[:, None]
    along, offset = b - a, a - pose.translation
    cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0]) / cross
        u = (offset[:, 0] * d[..., 1] - offset[:, 1] * d[..., 0]) / cross
    return np.asarray(np.where((t > 0.0) & (u >= 0.0) & (u <= 1.0), t, np.inf).min(axis=1))
