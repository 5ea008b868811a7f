"""Frames as columns for rerun: many scans of one entity are sent together, so that a scan costs little."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.viewer.covariance_shapes import ellipses, unconstrained_arrows, yaw_quaternions
from slam.run.viewer.palette import END_MARK, START_MARK
from slam.run.viewer.scene import PLOTS, Event, Frame

Float32Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Rows of one entity."""

    entity: str
    indexes: tuple[rr.TimeColumn, ...]
    columns: Any


def frame_chunks(frames: Sequence[Frame]) -> Iterator[Chunk]:
    """Everything that is drawn of these scans but their strokes."""
    when = times_of(frames)
    counts = [len(frame.points) for frame in frames]
    positions = at_height(_rounded(np.concatenate([frame.points for frame in frames])), 0.0)
    colours = np.concatenate([frame.point_colours for frame in frames])
    yield Chunk("map/scan", when, rr.Points3D.columns(positions=positions, colors=colours).partition(counts))
    yield Chunk("map/segments", when, _segments(frames))
    yield Chunk("map/robot", when, [*_transforms(frames), *ellipses(frames), *unconstrained_arrows(frames)])


def _rounded(points: FloatArray) -> FloatArray:
    """Round to 2 mm, less than a pixel and than the sensor's noise: the last bits of a float are most of a file."""
    return np.rint(points * 512.0) / 512.0


def _segments(frames: Sequence[Frame]) -> list[Any]:
    """Columns of lines, and of a mark at each start and each end."""
    counts = [len(frame.ends) for frame in frames]
    ends = at_height(np.concatenate([frame.ends for frame in frames]), 0.05)
    colours = np.concatenate([frame.end_colours for frame in frames])
    lines = rr.LineStrips3D.columns(strips=ends, colors=colours).partition(counts)
    marks = np.tile(np.array([START_MARK, END_MARK], np.uint32), len(ends))
    points = rr.Points3D.columns(positions=ends.reshape(-1, 3), colors=marks).partition([2 * count for count in counts])
    return [*lines, *points]


def stroke_chunks(before: Frame | None, frames: Sequence[Frame]) -> Iterator[Chunk]:
    """The strokes of the three trajectories from one scan to the next."""
    chain = list(frames) if before is None else [before, *frames]
    poses: dict[str, Callable[[Frame], Pose2D | None]] = {
        "odometry": lambda frame: frame.odometry, "slam": lambda frame: frame.slam, "truth": lambda frame: frame.truth,
    }  # fmt: skip
    for height, (name, pose) in enumerate(poses.items()):
        strokes = [(b, p.translation, q.translation) for a, b in pairwise(chain) if (p := pose(a)) and (q := pose(b))]
        if strokes:
            when = _times([frame.index for frame, *_ in strokes], [frame.stamp for frame, *_ in strokes])
            strips = at_height(np.array([ends for _, *ends in strokes]), 0.02 + 0.005 * height)
            columns = rr.LineStrips3D.columns(strips=strips).partition([1] * len(strokes))
            yield Chunk(f"map/trajectory/{name}", when, columns)


def plot_chunks(frames: Sequence[Frame], names: Sequence[str]) -> Iterator[Chunk]:
    """The points of these curves at these scans."""
    when = times_of(frames)
    for name in names:
        values = np.array([PLOTS[name].values(frame) for frame in frames], np.float64)
        columns = rr.Scalars.columns(scalars=values.ravel()).partition([values.shape[1]] * len(frames))
        yield Chunk(f"plots/{name}", when, columns)


def event_chunk(events: Sequence[Event]) -> Chunk:
    """Lines of text."""
    when = _times([event.scan for event in events], [event.stamp for event in events])
    texts, levels = [event.text for event in events], [event.level for event in events]
    return Chunk("events", when, rr.TextLog.columns(text=texts, level=levels))


def map_chunks(index: int, stamp: float, points: FloatArray, ends: FloatArray) -> Iterator[Chunk]:
    """The map as it stands at one scan: points (N, 2), walls (M, 2, 2)."""
    when = _times([index], [stamp])
    yield Chunk("map/points", when, rr.Points3D.columns(positions=at_height(points, 0.0)).partition([len(points)]))
    yield Chunk("map/lines", when, rr.LineStrips3D.columns(strips=at_height(ends, 0.01)).partition([len(ends)]))


def at_height(points: FloatArray, height: float) -> Float32Array:
    """Points (..., 2) of the plane as points (..., 3) at one height, metres: what is higher is seen from above."""
    lifted = np.empty((*points.shape[:-1], 3), np.float32)
    lifted[..., :2], lifted[..., 2] = points, height
    return lifted


def times_of(frames: Sequence[Frame]) -> tuple[rr.TimeColumn, ...]:
    """Times of these scans on both timelines."""
    return _times([frame.index for frame in frames], [frame.stamp for frame in frames])


def _times(scans: Sequence[int], stamps: Sequence[float]) -> tuple[rr.TimeColumn, ...]:
    return rr.TimeColumn("scan", sequence=scans), rr.TimeColumn("time", duration=np.asarray(stamps, np.float64))


def _transforms(frames: Sequence[Frame]) -> Any:
    poses = stack_poses(frame.robot for frame in frames)
    return rr.Transform3D.columns(translation=at_height(poses[:, :2], 0.06), quaternion=yaw_quaternions(poses[:, 2]))
