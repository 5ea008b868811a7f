"""Colours, as 0xRRGGBBAA, on a dark background; the colours of lines are safe for the colour-blind."""

from colorsys import hsv_to_rgb
from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.pose import FloatArray

Colour = NDArray[np.uint32]

GROUND: Final = 0x0E1116FF
GRID: Final = 0xFFFFFF12
TRUE_WALLS: Final = 0x5B677AFF
ROUTE: Final = 0x9D4EDDFF
MAP_POINTS: Final = 0xE3A6A6FF
MAP_LINES: Final = 0xF1F5F9FF
SLAM: Final = 0x56B4E9FF
ODOMETRY: Final = 0xE0561BFF
TRUTH: Final = 0xFFCC00FF
START_MARK: Final = 0x56B4E9FF
END_MARK: Final = 0xE0561BFF
UNSURE: Final = 0x9D4EDDFF
SONAR: Final = 0xC792EAFF
NO_SEGMENT: Final = 0x8A93A0FF
CLOSED: Final = 0x2EC4A0FF
"""The path after loop closing."""
LOOP: Final = 0xD7F75BFF
DOUBT: Final = 0xFF7AB8FF
"""Loops that are not accepted."""
BODY: Final = 0x1F5F8BFF
SERIES: Final = (0x56B4E9FF, 0xE0561BFF, 0xFFCC00FF)

_HUES: Final = 24


def _wheel() -> Colour:
    """Return bright hues around the colour wheel, starting with red."""
    rgb = [hsv_to_rgb(hue / _HUES, 0.62, 1.0) for hue in range(_HUES)]
    channels = np.round(255 * np.array(rgb)).astype(np.uint32)
    return (channels[:, 0] << 24 | channels[:, 1] << 16 | channels[:, 2] << 8 | 0xFF).astype(np.uint32)


_WHEEL: Final = _wheel()


def wall_colours(directions: FloatArray) -> Colour:
    """Return a colour for each segment (M,) by the direction of its normal in the map, radians.

    So a wall keeps its colour.
    """
    return _WHEEL[np.round(directions * (_HUES / (2 * np.pi))).astype(np.int64) % _HUES]
