"""SLAM for other programs: scans in, pose and walls out."""

import warnings
import weakref
from contextlib import ExitStack
from copy import deepcopy
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from hopslam.arguments import checked_lidar, checked_mount, checked_seed, checked_start
from hopslam.intake import Intake
from hopslam.line_map import Map, closed_map, state_of
from hopslam.scan import RANGE_MIN
from hopslam.segments import Segments
from hopslam.settings import SettingsLike, slam_config
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.line_slam import LineSlam
from slam.pose import FloatArray, Pose2D
from slam.run.closing_loops import LoopCloser
from slam.run.warm_up import is_first_run, warming_up
from slam.saved_slam import relocate, save


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Pose and state after one scan."""

    stamp: float
    """Seconds."""
    pose: Pose2D
    """Pose of the robot in the map: ``x``, ``y`` in metres, ``theta`` in radians."""
    covariance: FloatArray | None = field(repr=False)
    """Covariance (3, 3) of x, y, theta, map frame; None in paper mode."""
    lost: bool
    """True if the last scans did not fit the map."""
    loop_closed: bool
    """True if this scan closed a loop: pose and map have changed as a whole."""
    segments: Segments | None
    """Line segments of the scan, sensor frame; None if ``slam.update_distance`` left the scan out."""


class Slam:
    """Simultaneous localisation and mapping with a planar lidar.

    ``settings`` are ``"slam.key=value"``, one or several, or a SlamConfig. ``T_base_laser`` is the lidar on the robot
    and ``start`` the robot in the map at its first scan, each x, y, theta in metres and radians; without them, both are
    the origin. With ``saved_map``, a Map or the path of one, mapping goes on there; the robot then starts where it was
    last, or at ``start``. Reach and ``time_increment`` of the lidar are as in Scan; ``seed`` is for paper mode, which
    draws at random. Call ``update`` with each scan and ``finish`` after the last one.
    """

    def __init__(
        self,
        settings: SettingsLike = (),
        *,
        T_base_laser: Any = (0.0, 0.0, 0.0),
        start: Any = None,
        saved_map: Map | str | Path | None = None,
        range_min: float = RANGE_MIN,
        range_max: float = inf,
        time_increment: float = 0.0,
        seed: int = 0,
    ) -> None:
        self._config = slam_config(settings)
        if self._config.mode == "dead_reckoning":
            raise InputError("slam.mode=dead_reckoning looks at no scan; choose hopslam or paper")
        self._T_base_laser, self._seed = checked_mount("T_base_laser", T_base_laser), checked_seed(seed)
        self._intake = Intake(checked_lidar(range_min, range_max, time_increment))
        self._saved = None if saved_map is None else state_of(saved_map, self._config)
        first = Pose2D() if self._saved is None else self._saved.T_map_base
        self._start = first if start is None else checked_start("start", start)
        self._method: LineSlam | None = None  # made at the first scan, which shows whether there is odometry
        self._poses: list[tuple[float, float, float, float]] = []  # stamp and pose at each scan
        self._closer: LoopCloser | None = None
        self._result: Map | None = None

    @property
    def pose(self) -> Pose2D:
        """The robot in the map, as far as it is known now: ``x``, ``y`` in metres, ``theta`` in radians."""
        if self._result is not None:
            return self._result.pose
        return self._start if self._method is None else self._method.T_map_base

    @property
    def walls(self) -> FloatArray:
        """Current map as wall segments: start and end of each, (N, 2, 2), metres, map frame."""
        if self._result is not None:
            return self._result.walls
        return np.empty((0, 2, 2)) if self._method is None else self._method.lines.ends

    @property
    def map(self) -> Map:
        """Copy of the current map, with the pose estimated at each scan; later scans do not change it."""
        if self._result is not None:
            return self._result
        if self._method is None:
            raise InputError("there is no map before the first scan; call update(ranges, angles)")
        poses = np.array(self._poses)
        saved = deepcopy(save(self._method))
        return Map(self.walls, self._method.points.points.copy(), self.pose, poses[:, 1:], poses[:, 0], saved)

    def update(self, ranges: Any, angles: Any = None, odometry: Any = None, stamp: float | None = None) -> Estimate:
        """Take the next scan; return the estimate after it.

        The scan is ``ranges`` (N,) in metres with ``angles`` (N,) in radians, or a Scan alone. ``odometry`` is the pose
        x, y, theta that the robot computes from its wheels, in any fixed frame; ``stamp`` is the time of the first beam
        in seconds. Give each with every scan or with none. Without odometry the motion is estimated from the scans
        alone. InputError names the scan and the wrong argument, and leaves the state unchanged.
        """
        if self._result is not None:
            raise InputError(
                "finish() was called, and the map is closed; begin a new Slam, with saved_map to go on in it"
            )
        scan, moved, measured = self._intake.take(ranges, angles, odometry, stamp)
        method, closer = self._begun(measured)
        found = method.update(scan, moved)
        closer.add(found)
        self._poses.append((found.stamp, *found.T_map_base.as_array().tolist()))
        segments = None if found.segments is None else Segments(found.segments, scan.points())
        closed = found.closure is not None
        return Estimate(found.stamp, found.T_map_base, found.covariance, found.lost, closed, segments)

    def finish(self) -> Map:
        """End the run: close the last loops, refine all poses and walls together, and return the map.

        ``pose``, ``walls`` and ``map`` are those of the closed map from now on. If the process that searches for loops
        has died, the map stays as it was before, and a Python warning says so.
        """
        if self._result is None:
            as_known = self.map  # InputError before the first scan
            assert self._closer is not None
            closed = self._closer.closed()
            if self._closer.back_end_lost:
                warnings.warn(self._closer.back_end_lost, stacklevel=2)
            self._result = as_known if closed is None else closed_map(closed)
        return self._result

    def save(self, folder: str | Path) -> Path:
        """Write the current map; see ``Map.save``."""
        return self.map.save(folder)

    def __repr__(self) -> str:
        pose = self.pose
        return f"Slam({len(self._poses)} scans, at {pose.x:.3f}, {pose.y:.3f} m, {pose.theta:.3f} rad)"

    def _repr_png_(self) -> bytes | None:
        return self.map.picture() if self._poses else None

    def _begun(self, measured: bool) -> tuple[LineSlam, LoopCloser]:
        """Return the method and the loop closer, which the first scan makes, for runs with odometry or without."""
        if self._method is None or self._closer is None:
            config = self._config if measured else self._config.without_odometry()
            if is_first_run(config):
                beside = ExitStack()
                beside.enter_context(warming_up(Terminal(stderr=True), config))
                weakref.finalize(self, beside.close)
            if self._saved is None:
                self._method = LineSlam(config, self._T_base_laser, self._start, self._seed)
            else:
                self._method = relocate(config, self._T_base_laser, self._saved, self._start)
            self._closer = LoopCloser(self._method)
        return self._method, self._closer
