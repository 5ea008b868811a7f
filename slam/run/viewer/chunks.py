"""Frames as columns for rerun: many scans of one entity are sent together, so that a scan costs little."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, sin
from typing import Any, Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.viewer.loop_events import LoopsShown
from slam.run.viewer.palette import END_MARK, START_MARK
from slam.run.viewer.scene import PLOTS, Event, Frame

Float32Array = NDArray[np.float32]
_RADIUS_95: Final = 2.4477
"""Radius of the circle that contains 95 % of a normal distribution of unit variance in the plane: sqrt(-2 ln 0.05)."""
_ARROW: Final = 1.2
"""Length of an arrow to each side, metres."""
_DASH: Final = 0.2
"""Length of a dash, and of the gap behind it, metres."""
_NO_LINES: Final = np.empty((0, 2, 2))
_MIN_PLANE_LENGTH: Final = 0.05
"""An unconstrained direction is a unit vector of x, y and heading. If its part in x and y is shorter than this, only
the heading is unconstrained, and no arrow is drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Rows of one entity."""

    entity: str
    indexes: tuple[rr.TimeColumn, ...]
    columns: Any


def frame_chunks(frames: Sequence[Frame]) -> Iterator[Chunk]:
    """Yield all chunks of these scans except their strokes."""
    when = _times_of(frames)
    counts = [len(frame.points) for frame in frames]
    positions = at_height(_rounded(np.concatenate([frame.points for frame in frames])), 0.0)
    colours = np.concatenate([frame.point_colours for frame in frames])
    yield Chunk("map/scan", when, rr.Points3D.columns(positions=positions, colors=colours).partition(counts))
    yield Chunk("map/segments", when, _segments(frames))
    poses = stack_poses(frame.robot for frame in frames)
    places = rr.Transform3D.columns(translation=at_height(poses[:, :2], 0.06), quaternion=_yaw_quaternions(poses[:, 2]))
    if any(frame.sonar is not None for frame in frames):
        echoes = [np.empty((0, 2)) if frame.sonar is None else frame.sonar for frame in frames]
        columns = rr.Points3D.columns(positions=at_height(np.concatenate(echoes), 0.03)).partition(
            list(map(len, echoes))
        )
        yield Chunk("map/sonar", when, columns)
    yield Chunk("map/robot", when, [*places, *_ellipses(frames), *_unconstrained_arrows(frames)])


def _rounded(points: FloatArray) -> FloatArray:
    """Round to 2 mm, less than a pixel and than the sensor's noise, so that files are smaller."""
    return np.rint(points * 512.0) / 512.0


def _segments(frames: Sequence[Frame]) -> list[Any]:
    """Columns of lines, with a mark at each start and each end."""
    counts = [len(frame.ends) for frame in frames]
    ends = at_height(np.concatenate([frame.ends for frame in frames]), 0.05)
    colours = np.concatenate([frame.end_colours for frame in frames])
    lines = rr.LineStrips3D.columns(strips=ends, colors=colours).partition(counts)
    marks = np.tile(np.array([START_MARK, END_MARK], np.uint32), len(ends))
    points = rr.Points3D.columns(positions=ends.reshape(-1, 3), colors=marks).partition([2 * count for count in counts])
    return [*lines, *points]


def _ellipses(frames: Sequence[Frame]) -> Any:
    """Columns of a flat ellipsoid per scan, in the robot's frame; empty without a covariance."""
    known = [(frame.robot.theta, frame.covariance) for frame in frames if frame.covariance is not None]
    counts = [int(frame.covariance is not None) for frame in frames]
    variances, axes = np.linalg.eigh(np.array([C[:2, :2] for _, C in known]).reshape(-1, 2, 2))
    sizes = np.full((len(known), 3), 1e-3, np.float32)
    sizes[:, :2] = _RADIUS_95 * np.sqrt(np.maximum(variances, 0.0))
    turns = _yaw_quaternions(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]) - np.array([theta for theta, _ in known]))
    return rr.Ellipsoids3D.columns(half_sizes=sizes, quaternions=turns).partition(counts)


def _unconstrained_arrows(frames: Sequence[Frame]) -> Any:
    """Columns of arrows, in the robot's frame, to both sides along each direction that only odometry fixes."""
    vectors: list[tuple[float, float, float]] = []
    counts = []
    for frame in frames:
        before = len(vectors)
        for x, y, _ in frame.unconstrained.tolist() if frame.unconstrained is not None else ():
            if hypot(x, y) > _MIN_PLANE_LENGTH:
                way = atan2(y, x) - frame.robot.theta
                c, s = _ARROW * cos(way), _ARROW * sin(way)
                vectors += [(c, s, 0.0), (-c, -s, 0.0)]
        counts.append(len(vectors) - before)
    return rr.Arrows3D.columns(vectors=np.array(vectors, np.float32).reshape(-1, 3)).partition(counts)


def _yaw_quaternions(angles: FloatArray) -> Float32Array:
    """Return quaternions (N, 4), x y z w, of rotations about the vertical axis."""
    turns = np.zeros((len(angles), 4), np.float32)
    turns[:, 2], turns[:, 3] = np.sin(0.5 * angles), np.cos(0.5 * angles)
    return turns


def stroke_chunks(before: Frame | None, frames: Sequence[Frame]) -> Iterator[Chunk]:
    """Yield the strokes of the three trajectories from one scan to the next."""
    chain = list(frames) if before is None else [before, *frames]
    poses: dict[str, Callable[[Frame], Pose2D | None]] = {
        "odometry": lambda frame: frame.odometry, "slam": lambda frame: frame.slam, "truth": lambda frame: frame.truth,
    }  # fmt: skip
    for height, (name, pose) in enumerate(poses.items()):
        strokes = [
            (b, p.translation, q.translation)
            for a, b in pairwise(chain)
            if (p := pose(a)) and (q := pose(b)) and not (b.jumped and name == "slam")
        ]
        if strokes:
            when = _times([frame.index for frame, *_ in strokes], [frame.stamp for frame, *_ in strokes])
            strips = at_height(np.array([ends for _, *ends in strokes]), 0.02 + 0.005 * height)
            columns = rr.LineStrips3D.columns(strips=strips).partition([1] * len(strokes))
            yield Chunk(f"map/trajectory/{name}", when, columns)


def plot_chunks(frames: Sequence[Frame], names: Sequence[str]) -> Iterator[Chunk]:
    """Yield the points of these curves at these scans."""
    when = _times_of(frames)
    for name in names:
        values = np.array([PLOTS[name].values(frame) for frame in frames], np.float64)
        columns = rr.Scalars.columns(scalars=values.ravel()).partition([values.shape[1]] * len(frames))
        yield Chunk(f"plots/{name}", when, columns)


def event_chunk(events: Sequence[Event]) -> Chunk:
    """Return lines of text."""
    when = _times([event.scan for event in events], [event.stamp for event in events])
    texts, levels = [event.text for event in events], [event.level for event in events]
    return Chunk("events", when, rr.TextLog.columns(text=texts, level=levels))


def map_chunks(index: int, stamp: float, points: FloatArray, ends: FloatArray) -> Iterator[Chunk]:
    """Yield the map at one scan: points (N, 2), walls (M, 2, 2)."""
    when = _times([index], [stamp])
    yield Chunk("map/points", when, rr.Points3D.columns(positions=at_height(points, 0.0)).partition([len(points)]))
    yield Chunk("map/lines", when, rr.LineStrips3D.columns(strips=at_height(ends, 0.01)).partition([len(ends)]))


def loop_chunks(index: int, stamp: float, shown: LoopsShown) -> Iterator[Chunk]:
    """Yield path and loops as known from one scan on; doubtful loops are dashed and crossed out."""
    when = _times([index], [stamp])
    if len(shown.path):
        way = rr.LineStrips3D.columns(strips=[at_height(shown.path, 0.04)]).partition([1])
        yield Chunk("map/trajectory/closed", when, way)
    lines = rr.LineStrips3D.columns(strips=at_height(shown.loops, 0.07)).partition([len(shown.loops)])
    marks = at_height(shown.loops.mean(axis=1), 0.07)
    yield Chunk("map/loops", when, [*lines, *rr.Points3D.columns(positions=marks).partition([len(marks)])])
    dashes = at_height(np.concatenate([*map(_dashes, shown.doubted), *map(_cross, shown.doubted), _NO_LINES]), 0.07)
    yield Chunk("map/loops/doubted", when, rr.LineStrips3D.columns(strips=dashes).partition([len(dashes)]))


def _dashes(ends: FloatArray) -> FloatArray:
    """Return a line (2, 2) as dashes, (M, 2, 2)."""
    pieces = 2 * int(np.hypot(*(ends[1] - ends[0])) / (2 * _DASH)) + 1
    corners = np.linspace(ends[0], ends[1], pieces + 1)
    return np.stack([corners[:-1:2], corners[1::2]], axis=1)


def _cross(ends: FloatArray) -> FloatArray:
    """Return the two lines (2, 2, 2) of a cross in the middle of a line."""
    return np.asarray(ends.mean(axis=0) + _DASH * np.array([[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]))


def at_height(points: FloatArray, height: float) -> Float32Array:
    """Lift points (..., 2) of the plane to points (..., 3) at one height, metres; higher ones cover lower ones."""
    lifted = np.empty((*points.shape[:-1], 3), np.float32)
    lifted[..., :2], lifted[..., 2] = points, height
    return lifted


def _times_of(frames: Sequence[Frame]) -> tuple[rr.TimeColumn, ...]:
    """Return the times of these scans on both timelines."""
    return _times([frame.index for frame in frames], [frame.stamp for frame in frames])


def _times(scans: Sequence[int], stamps: Sequence[float]) -> tuple[rr.TimeColumn, ...]:
    return rr.TimeColumn("scan", sequence=scans), rr.TimeColumn("time", duration=np.asarray(stamps, np.float64))
