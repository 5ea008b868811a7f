"""Watcher that counts how often the lidar saw each part of the true walls."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled
from slam.deskew import deskewed
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D
from slam.run.scoring.true_walls import true_walls
from slam.run.step import Step
from slam.scan import COS, SIN

TIMES: Final = 3
"""Number of scans that must have seen a sample of a wall, for the map to be expected to contain it."""
MOVED: Final = 0.1, float(np.radians(10.0))
"""Motion between two counted scans, metres or radians, so that a robot at rest counts once."""
SAME_RANGE = 0.1  # metres, and share of the range: largest difference of an echo from the wall
MIN_INCIDENCE = float(np.cos(np.radians(75.0)))  # least cosine between a beam and the normal of a face that it sees


class SeenWalls:
    """Watcher that counts, for every sample of the true walls, the scans that saw it from the true poses.

    A scan sees the part of a face between two neighbouring beams that both hit this face first, at most 75 degrees off
    its normal, and whose ranges match it: within 0.1 m, or a tenth of the range if that is more. Memory does not grow
    with the run.
    """

    def __init__(self, outlines: Sequence[FloatArray], T_base_laser: Pose2D) -> None:
        self.walls = true_walls(outlines)
        self.scans = np.zeros(len(self.walls.samples), np.int64)
        """Number of scans that saw each sample, (N,)."""
        self._firsts = np.searchsorted(self.walls.face_of, np.arange(len(self.walls.faces) + 1))
        self._T_base_laser = T_base_laser
        self._last: Pose2D | None = None

    @property
    def seen(self) -> NDArray[np.bool_]:
        """True for the samples that were seen often enough, (N,)."""
        return self.scans >= TIMES

    def on_step(self, step: Step) -> None:
        """Count the samples that this scan saw, if the true pose is known and the robot has moved enough."""
        T_map_base, odometry = step.observation.T_map_base, step.observation.odometry
        if T_map_base is None or (self._last is not None and not _has_moved(self._last, T_map_base)):
            return
        self._last = T_map_base
        scan = deskewed(step.observation.scan, odometry.twist, self._T_base_laser)
        T_map_laser = T_map_base @ self._T_base_laser
        beams = np.column_stack([scan.fan[COS], scan.fan[SIN]]) @ T_map_laser.rotation.T
        ranges = np.where(scan.echoes, scan.ranges, np.nan)
        face, along = _faces_met(T_map_laser.translation, beams, ranges, self.walls.faces)
        _count(face, along, self._firsts, self.walls.lengths, self.scans)


def _has_moved(last: Pose2D, now: Pose2D) -> bool:
    metres, radians = MOVED
    return last.distance(now) >= metres or abs(last.between(now).theta) >= radians


@compiled
def _faces_met(
    origin: FloatArray, beams: FloatArray, ranges: FloatArray, faces: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the face that each beam (B, 2) sees, (B,), -1 for none, and the distance from its start, (B,), metres.

    Only a face that has the origin (2,) to its left can be seen; ``ranges`` (B,) are nan without an echo.
    """
    B = len(beams)
    face, along = np.full(B, -1, np.int64), np.zeros(B)
    nearest, cosine = np.full(B, np.inf), np.zeros(B)
    farthest = 0.0
    for b in range(B):
        if ranges[b] > farthest:
            farthest = ranges[b]
    reach = (farthest + SAME_RANGE) / (1.0 - SAME_RANGE)  # no echo comes from farther
    for f in range(len(faces)):
        x, y = faces[f, 0, 0] - origin[0], faces[f, 0, 1] - origin[1]
        dx, dy = faces[f, 1, 0] - faces[f, 0, 0], faces[f, 1, 1] - faces[f, 0, 1]
        length = np.hypot(dx, dy)
        dx, dy = dx / length, dy / length
        offset = x * -dy + y * dx  # of the face from the origin, along its left normal
        if offset >= 0.0 or -offset > reach or _is_beyond(x, y, length * dx, length * dy, reach):
            continue
        for b in range(B):
            toward = beams[b, 0] * dy - beams[b, 1] * dx  # cosine between the beam and the inward normal
            if toward <= 0.0:
                continue
            r = -offset / toward
            if r < nearest[b]:
                t = (r * beams[b, 0] - x) * dx + (r * beams[b, 1] - y) * dy
                if t >= 0.0 and t <= length:
                    nearest[b], face[b], along[b], cosine[b] = r, f, t, toward
    for b in range(B):
        is_there = abs(ranges[b] - nearest[b]) <= SAME_RANGE * max(1.0, nearest[b])  # false without an echo
        if not is_there or cosine[b] < MIN_INCIDENCE:
            face[b] = -1
    return face, along


@compiled
def _is_beyond(x: float, y: float, dx: float, dy: float, reach: float) -> bool:
    """Return True if the bounding box of the line from (x, y) by (dx, dy) is farther than ``reach`` in x or in y."""
    return (
        min(x, x + dx) > reach or max(x, x + dx) < -reach or min(y, y + dy) > reach or max(y, y + dy) < -reach
    )  # fmt: skip


@compiled
def _count(face: IntArray, along: FloatArray, firsts: IntArray, lengths: FloatArray, scans: IntArray) -> None:
    """Add 1 to the ``scans`` of every sample between two neighbouring beams that see its face."""
    for b in range(1, len(face)):
        f = face[b]
        if f >= 0 and face[b - 1] == f:
            first, count = firsts[f], firsts[f + 1] - firsts[f]
            part = lengths[f] / count
            low, high = min(along[b - 1], along[b]), max(along[b - 1], along[b])
            for k in range(int(np.ceil(low / part - 0.5)), int(np.ceil(high / part - 0.5))):
                if k >= 0 and k < count:
                    scans[first + k] += 1
