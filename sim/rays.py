"""The beams of one sweep as rays in the plane: where each starts and where it points. Metres, radians, map frame."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import cos, sin

import numpy as np

from sim.plan_grid import outline_edges
from slam.compiled import compiled, wrapped
from slam.pose import FloatArray
from slam.scenario.furniture import Movable
from slam.scenario.solids import outlines_at


@dataclass(frozen=True, slots=True, eq=False)
class ScanMotion:
    """Motion of everything while the beams fired, the first of them at time 0 and with row 0."""

    path: FloatArray
    """(S, 3): x, y, theta of ``T_map_base``, one row every ``step`` seconds; one row alone: it stood still."""
    legs: FloatArray
    """(S, L, 2): where people's legs stood at the same times."""
    step: float
    things: FloatArray = field(default_factory=lambda: np.empty((1, 0, 3)))
    """(S, M, 3): x, y, theta of the furniture that can be pushed, at the same times."""


@compiled
def rays_of(
    path: FloatArray, step: float, mount: FloatArray, beams: FloatArray, time_increment: float
) -> tuple[FloatArray, FloatArray]:
    """Origins (N, 2) and unit directions (N, 2) of the beams, each from where the sensor is when it fires.

    ``mount`` (2,) is where the sensor sits on the base and ``beams`` (N, 2) where its beams point, as unit vectors in
    the frame of the base. Between two rows of ``path`` the pose changes evenly.
    """
    origins, directions = np.empty(beams.shape), np.empty(beams.shape)
    last = len(path) - 1
    for j in range(len(beams)):
        at = j * time_increment / step
        k = min(int(at), last)
        n, share = min(k + 1, last), at - k
        theta = path[k, 2] + share * wrapped(path[n, 2] - path[k, 2])
        c, s = cos(theta), sin(theta)
        origins[j, 0] = path[k, 0] + share * (path[n, 0] - path[k, 0]) + c * mount[0] - s * mount[1]
        origins[j, 1] = path[k, 1] + share * (path[n, 1] - path[k, 1]) + s * mount[0] + c * mount[1]
        directions[j, 0] = c * beams[j, 0] - s * beams[j, 1]
        directions[j, 1] = s * beams[j, 0] + c * beams[j, 1]
    return origins, directions


@compiled
def stop_at_legs(
    origins: FloatArray, directions: FloatArray, ranges: FloatArray,
    legs: FloatArray, radii: FloatArray, steps: float,
) -> None:  # fmt: skip
    """Shorten ``ranges`` (N,) where a leg, a circle of ``radii`` (L,), stands in the way when the beam fires.

    ``legs`` (C, L, 2) is where they stand; from one beam to the next, ``steps`` rows pass.
    """
    last = len(legs) - 1
    for j in range(len(ranges)):
        k = min(int(j * steps), last)
        n, share = min(k + 1, last), j * steps - k
        for leg in range(len(radii)):
            x = legs[k, leg, 0] + share * (legs[n, leg, 0] - legs[k, leg, 0]) - origins[j, 0]
            y = legs[k, leg, 1] + share * (legs[n, leg, 1] - legs[k, leg, 1]) - origins[j, 1]
            along = x * directions[j, 0] + y * directions[j, 1]
            across = x * directions[j, 1] - y * directions[j, 0]
            inside = radii[leg] * radii[leg] - across * across
            if along > 0.0 and inside > 0.0:
                ranges[j] = min(ranges[j], max(along - np.sqrt(inside), 0.0))


@compiled
def stop_at_outlines(
    origins: FloatArray, directions: FloatArray, ranges: FloatArray,
    places: FloatArray, segments: FloatArray, steps: float,
) -> None:  # fmt: skip
    """Shorten ``ranges`` (N,) where a segment of a moving outline stands in the way when the beam fires.

    ``places`` (C, M, 3) are x, y and theta of the outlines' frames; from one beam to the next, ``steps`` rows pass.
    ``segments`` (K, 5) are the number of a frame, and in it x, y of one end and from there to the other.
    """
    last = len(places) - 1
    for j in range(len(ranges)):
        k = min(int(j * steps), last)
        n, share = min(k + 1, last), j * steps - k
        owner = -1
        for row in range(len(segments)):
            if segments[row, 0] != owner:
                owner = int(segments[row, 0])
                theta = places[k, owner, 2] + share * wrapped(places[n, owner, 2] - places[k, owner, 2])
                c, s = cos(theta), sin(theta)
                x = origins[j, 0] - places[k, owner, 0] - share * (places[n, owner, 0] - places[k, owner, 0])
                y = origins[j, 1] - places[k, owner, 1] - share * (places[n, owner, 1] - places[k, owner, 1])
                ox, oy = c * x + s * y, c * y - s * x  # the ray in the frame of the outline
                dx = c * directions[j, 0] + s * directions[j, 1]
                dy = c * directions[j, 1] - s * directions[j, 0]
            sx, sy, ux, uy = segments[row, 1], segments[row, 2], segments[row, 3], segments[row, 4]
            det = dx * uy - dy * ux
            if det == 0.0:
                continue
            along = ((sx - ox) * uy - (sy - oy) * ux) / det
            across = ((sx - ox) * dy - (sy - oy) * dx) / det
            if 0.0 <= along < ranges[j] and 0.0 <= across <= 1.0:
                ranges[j] = along


class MovingOutlines:
    """Outlines of things that move, in a horizontal plane at ``height`` metres."""

    def __init__(self, movables: Sequence[Movable], height: float) -> None:
        ends = [
            np.insert(outline_edges(outline), 0, owner, axis=1)
            for owner, thing in enumerate(movables)
            for outline in outlines_at(thing.prisms, height)
        ]
        self._segments = np.concatenate([np.empty((0, 5)), *ends])
        """(K, 5): the number of the thing; x, y of one end in its frame, and from there to the other."""

    def stop(
        self, origins: FloatArray, directions: FloatArray, ranges: FloatArray, places: FloatArray, steps: float
    ) -> None:
        """Shorten ``ranges`` (N,) in place where an outline stands in the way of a ray when it fires.

        ``places`` (C, M, 3) are x, y and theta of the things; from one ray to the next, ``steps`` rows pass.
        """
        if len(self._segments):
            stop_at_outlines(origins, directions, ranges, places, self._segments, steps)
