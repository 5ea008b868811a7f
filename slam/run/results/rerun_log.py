"""``--rerun FILE``: a run as a recording for the rerun viewer, seen from above, y up."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from slam.errors import InputError
from slam.pose import FloatArray, Pose2D
from slam.run.loop import Step

_COLOURS = {"slam": (44, 160, 44), "odometry": (214, 39, 40), "truth": (230, 230, 230)}
_P3DX_OUTLINE = np.array(
    [[0.0, 0.0], [0.21, 0.0], [0.21, -0.19], [-0.30, -0.19], [-0.30, 0.19], [0.21, 0.19], [0.21, 0.0]]
)
"""With a stroke from the axle's middle to the front."""


def check_recording(path: Path) -> None:
    """Refuse, by InputError, a file that a recording cannot or should not be written to."""
    if path.suffix != ".rrd":
        raise InputError(f"{path}: a recording needs a name that ends in .rrd; choose another --rerun FILE")
    try:
        path.open("ab").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --rerun FILE") from error


class RerunLog:
    """A watcher that writes what it sees to .rrd files."""

    def __init__(self, paths: Sequence[Path], T_base_laser: Pose2D, outlines: Sequence[FloatArray]) -> None:
        self._T_base_laser = T_base_laser
        self._last: dict[str, Pose2D] = {}
        self._T_map_odom = Pose2D()
        files = {path.resolve() for path in paths}
        self._stream = rr.RecordingStream("hopslam", send_properties=False)
        self._stream.set_sinks(*map(rr.FileSink, sorted(files)), default_blueprint=_blueprint(outlines))
        self._stream.log("map/walls", _strips([np.vstack([o, o[:1]]) for o in outlines], (110, 110, 110)), static=True)
        self._stream.log("robot", _strips([_P3DX_OUTLINE], _COLOURS["slam"]), static=True)

    def see(self, step: Step) -> None:
        """Write one step."""
        estimate, observation = step.estimate, step.observation
        if step.index == 0:
            self._T_map_odom = estimate.T_map_base @ observation.odometry.T_odom_base.inverse()
        self._stream.set_time("scan", sequence=step.index)
        self._stream.set_time("time", duration=estimate.stamp)
        T_map_laser = estimate.T_map_base @ self._T_base_laser
        points = _flat(T_map_laser.transform(observation.scan.points()))
        self._stream.log("robot", _transform(estimate.T_map_base))
        self._stream.log("scan/points", rr.Points3D(points, colors=(255, 127, 14), radii=0.015))
        self._log_poses(step)
        if estimate.segments is not None:
            segments = estimate.segments.transformed(T_map_laser)
            ends = np.stack([segments.start, segments.end], axis=1)
            self._stream.log("map/points", rr.Points3D(points, colors=(227, 119, 194), radii=0.008))
            self._stream.log("map/lines", _strips(ends, (255, 255, 255)))
            self._stream.log("plots/iterations", rr.Scalars(estimate.match.iterations))
            self._stream.log("plots/slam_ms", rr.Scalars(1e3 * estimate.total_time))

    def _log_poses(self, step: Step) -> None:
        """A stroke of each trajectory, and the error where the truth is known."""
        self._stroke("slam", step.estimate.T_map_base)
        self._stroke("odometry", self._T_map_odom @ step.observation.odometry.T_odom_base)
        truth = step.observation.T_map_base
        if truth is not None:
            self._stroke("truth", truth)
            error = truth.between(step.estimate.T_map_base)
            self._stream.log("plots/error/position_m", rr.Scalars(error.distance(Pose2D())))
            self._stream.log("plots/error/heading_rad", rr.Scalars(error.theta))

    def _stroke(self, name: str, pose: Pose2D) -> None:
        last = self._last.get(name, pose)
        self._last[name] = pose
        stroke = np.array([[last.translation, pose.translation]])
        self._stream.log(f"trajectory/{name}", _strips(stroke, _COLOURS[name]))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, tb: TracebackType | None
    ) -> None:
        self._stream.flush()
        self._stream.disconnect()


def _blueprint(outlines: Sequence[FloatArray]) -> rrb.Blueprint:
    """The map from above, with all that was seen so far, beside the curves; the eye over the middle of the world."""
    corners = np.vstack(outlines) if outlines else np.array([[-10.0, -10.0], [10.0, 10.0]])
    (x, y), height = (corners.min(axis=0) + corners.max(axis=0)) / 2, 1.2 * float(np.ptp(corners, axis=0).max())
    so_far = rrb.VisibleTimeRanges(
        timeline="scan", start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.cursor_relative()
    )
    kept = ("map/points", "map/lines", "trajectory/slam", "trajectory/odometry", "trajectory/truth")
    above = rrb.EyeControls3D(position=(x, y, height), look_target=(x, y, 0), eye_up=(0, 1, 0))
    plan = rrb.Spatial3DView(name="map", origin="/", eye_controls=above, overrides={path: [so_far] for path in kept})
    curves = rrb.Vertical(
        rrb.TimeSeriesView(name="error", origin="plots/error"),
        rrb.TimeSeriesView(name="iterations", origin="plots/iterations"),
        rrb.TimeSeriesView(name="SLAM ms", origin="plots/slam_ms"),
    )
    return rrb.Blueprint(rrb.Horizontal(plan, curves, column_shares=[3, 1]), collapse_panels=True)


def _flat(points: FloatArray) -> Any:
    """Points (..., 2) of the plane as points (..., 3) at height 0."""
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1).astype(np.float32)


def _strips(strips: Any, colour: tuple[int, int, int]) -> rr.LineStrips3D:
    return rr.LineStrips3D([_flat(strip) for strip in strips], colors=colour, radii=0.012)


def _transform(pose: Pose2D) -> rr.Transform3D:
    half = pose.theta / 2.0
    turn = rr.Quaternion(xyzw=(0.0, 0.0, sin(half), cos(half)))
    return rr.Transform3D(translation=(pose.x, pose.y, 0.0), quaternion=turn)
