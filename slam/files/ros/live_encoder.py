"""Messages of a running robot that are not in a log: map, joints, battery, time."""

from collections.abc import Sequence
from math import nan
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from slam.files.ros.encoder import Encoder
from slam.files.ros.messages import BATTERY, CLOCK, GRID, JOINTS, MARKERS, TEXT, UNSURE_POSE
from slam.pose import FloatArray, Pose2D
from slam.robot import Battery

_LINE_LIST: Final = 5
"""Type LINE_LIST of a ``visualization_msgs/Marker``, whose points are the ends of lines in pairs."""
_LINE_WIDTH: Final = 0.03
"""Width of the lines, metres."""
_LINE_COLOUR: Final = 0.85, 0.15, 0.10, 1.0
_PLANAR: Final = np.array([0, 1, 5])
"""Rows of x, y and the turn about z in the covariance (6, 6) of a pose in space."""


class LiveEncoder(Encoder):
    """Encodes the additional messages of a running robot."""

    def clock(self, stamp: float) -> bytes:
        """Encode ``rosgraph_msgs/Clock`` with the present time."""
        return self._cdr(CLOCK, self._time(stamp))

    def unsure_pose(self, stamp: float, pose: Pose2D, covariance: FloatArray | None) -> bytes:
        """Encode ``geometry_msgs/PoseWithCovarianceStamped`` in frame ``map``.

        ``covariance`` (3, 3) is of x, y and theta; None, not known, is sent as zeros.
        """
        in_space = np.zeros((6, 6))
        if covariance is not None:
            in_space[np.ix_(_PLANAR, _PLANAR)] = covariance
        placed = self._make("geometry_msgs/msg/PoseWithCovariance", self._pose(pose), in_space.ravel())
        return self._cdr(UNSURE_POSE, self._header(stamp, "map"), placed)

    def joints(self, stamp: float, names: Sequence[str], angles: FloatArray, speeds: FloatArray) -> bytes:
        """Encode ``sensor_msgs/JointState``: angles in radians, speeds in rad/s."""
        return self._cdr(JOINTS, self._header(stamp, ""), list(names), angles, speeds, np.empty(0))

    def battery(self, stamp: float, battery: Battery | None) -> bytes:
        """Encode ``sensor_msgs/BatteryState``: the voltage, nan if unknown; all other values are unknown."""
        volts = nan if battery is None else battery.volts
        none, status, health, technology = np.empty(0, np.float32), 0, 0, 0
        return self._cdr(
            BATTERY, self._header(stamp, "base_link"), volts, *[nan] * 6, status, health, technology,
            battery is not None, none, none, "", "",
        )  # fmt: skip

    def grid(self, stamp: float, cells: NDArray[np.int8], corner: FloatArray, cell: float) -> bytes:
        """Encode ``nav_msgs/OccupancyGrid`` in frame ``map``, of cells (rows, columns), the lowest row first.

        ``corner`` (2,) is the outer corner of cell [0, 0], and ``cell`` the side of each, metres. A cell is 0 if free,
        100 if occupied, -1 if unknown.
        """
        rows, columns = cells.shape
        origin = self._pose(Pose2D(float(corner[0]), float(corner[1])))
        info = self._make("nav_msgs/msg/MapMetaData", self._time(stamp), cell, columns, rows, origin)
        return self._cdr(GRID, self._header(stamp, "map"), info, cells.ravel())

    def lines(self, stamp: float, ends: FloatArray) -> bytes:
        """Encode ``visualization_msgs/MarkerArray`` in frame ``map``: a list of lines with these ends (N, 2, 2)."""
        make = self._make
        points = [make("geometry_msgs/msg/Point", x, y, 0.0) for x, y in ends.reshape(-1, 2).tolist()]
        colour = make("std_msgs/msg/ColorRGBA", *_LINE_COLOUR)
        scale = self._vector(_LINE_WIDTH)
        marker = make(
            "visualization_msgs/msg/Marker", self._header(stamp, "map"), "lines", 0, _LINE_LIST, 0,
            self._pose(Pose2D()), scale, colour, make("builtin_interfaces/msg/Duration", 0, 0), False, points, [],
            *self._no_mesh(),
        )  # fmt: skip
        return self._cdr(MARKERS, [marker])

    def text(self, text: str) -> bytes:
        """Encode ``std_msgs/String``."""
        return self._cdr(TEXT, text)

    def _no_mesh(self) -> tuple[Any, ...]:
        """Return the last fields of a marker, which a list of lines does not use."""
        none = np.empty(0, np.uint8)
        texture = self._make("sensor_msgs/msg/CompressedImage", self._header(0.0, ""), "", none)
        return "", texture, [], "", "", self._make("visualization_msgs/msg/MeshFile", "", none), False
