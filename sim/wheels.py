"""The wheels of the P3-DX: their size, and the units in which its firmware counts and reports their motion."""

from math import pi
from typing import Final

WHEEL_RADIUS: Final = 0.0975
"""Radius of the wheels in p3dx.urdf, metres."""
TICKS_PER_TURN: Final = 76_600
"""Encoder ticks per turn: 500 lines, read on 4 edges, behind a 38.3:1 gear; 125 ticks/mm, the vendor's table says
128."""
TICKS_PER_RADIAN: Final = TICKS_PER_TURN / (2.0 * pi)
TRACK: Final = 0.330
"""Distance between the wheels in p3dx.urdf, metres."""
MILLIMETRE: Final = 1e-3
"""Unit of positions (m) and wheel speeds (m/s) in ARCOS: DistConvFactor and VelConvFactor of p3dx-sh.p."""
ANGLE_UNIT: Final = 2.0 * pi / 4096
"""Unit of headings in ARCOS, radians: AngleConvFactor of p3dx-sh.p."""
