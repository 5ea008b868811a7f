"""A look at the emulated world from outside."""

from __future__ import annotations

from dataclasses import dataclass

from slam.pose import FloatArray, Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class EmulatorState:
    """Metres, radians, seconds since the emulator was made."""

    stamp: float
    T_map_base: Pose2D
    T_odom_base: Pose2D
    """Where the wheels say that the base is, in the frame where it was put down."""
    points: FloatArray
    """(N, 2): where the beams of the last turn ended, sensor frame; none while the laser is off."""
    stalled: bool
