"""Collisions, and the bumper segments that were pressed, from the contacts of the robot's body."""

from collections.abc import Iterable
from math import atan2, cos, floor, pi, sin
from typing import Final, NamedTuple

from slam.compiled import compiled_on_views

SEGMENTS: Final = 5
"""Number of segments of the front bumper, and of the rear one."""
SEGMENT_ANGLE: Final = pi / 6.0
"""Angle of each segment, seen from the middle of the axle; the flanks between front and rear have none. Our choice."""
TOUCH: Final = 1e-3
"""Two bodies touch when closer than this, metres; PyBullet lists contacts of bodies up to 20 mm apart."""

Place = tuple[float, float, float]
"""x, y, theta of the base in the map."""


class Contact(NamedTuple):
    """A contact point of the body: x and y in the map frame, metres."""

    x: float
    y: float
    pushable: bool
    """True for a contact with furniture that can be pushed."""


class Bumpers:
    """Gathers contacts until they are read."""

    def __init__(self) -> None:
        self._forget()

    def add(self, contacts: Iterable[Contact], place: Place) -> None:
        """Add contacts; the base stands at ``place``."""
        for contact in contacts:
            self._collided |= not contact.pushable
            segment = segment_at(contact, place)
            if segment is not None:
                self._pressed[segment] = True

    def read(self) -> tuple[bool, tuple[bool, ...]]:
        """Return whether the robot touched anything fixed since the last reading, and the pressed segments.

        Front segments come first, then rear ones, each from the robot's left to its right.
        """
        collided, pressed = self._collided, tuple(self._pressed)
        self._forget()
        return collided, pressed

    def _forget(self) -> None:
        self._collided = False
        self._pressed = [False] * (2 * SEGMENTS)


def segment_at(contact: Contact, place: Place) -> int | None:
    """Return the number of the segment in that direction from the base; None on a flank."""
    x, y, theta = place
    dx, dy = contact.x - x, contact.y - y
    number = bumper_segment(cos(theta) * dx + sin(theta) * dy, cos(theta) * dy - sin(theta) * dx)
    return None if number < 0 else number


@compiled_on_views
def bumper_segment(ahead: float, left: float) -> int:
    """Return the number of the segment towards a point in the base frame; -1 on a flank."""
    in_front = ahead > 0.0
    bearing = atan2(left, abs(ahead))  # from straight ahead or straight back, positive to the left
    number = floor((SEGMENTS * SEGMENT_ANGLE / 2.0 - bearing) / SEGMENT_ANGLE)
    if not 0 <= number < SEGMENTS:
        return -1
    return number if in_front else SEGMENTS + number


def segments_of(pressed: int) -> tuple[bool, ...]:
    """Return for each segment whether its bit is set in ``pressed``."""
    return tuple(bool(pressed >> k & 1) for k in range(2 * SEGMENTS))
