"""Outlines of things that move while the beams of a scan fire. Metres, radians."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from sim.wall_plan import outline_edges
from slam.compiled import compiled, wrapped
from slam.pose import FloatArray
from slam.scenario.furniture import Movable
from slam.scenario.solids import outlines_at


@compiled
def stop_at_outlines(
    rays: FloatArray, ranges: FloatArray, places: FloatArray, segments: FloatArray, steps: float
) -> None:
    """Shorten ``ranges`` (N,) of ``rays`` (5, N) where a segment of a moving outline is nearer.

    ``places`` (C, M, 3) are x, y and theta of the outlines' frames at C times; from one beam to the next the time
    advances by ``steps`` rows. ``segments`` (K, 5) have the number of their frame and, in that frame, x and y of one
    end and of the vector to the other end.
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
                x = rays[0, j] - places[k, owner, 0] - share * (places[n, owner, 0] - places[k, owner, 0])
                y = rays[1, j] - places[k, owner, 1] - share * (places[n, owner, 1] - places[k, owner, 1])
                ox, oy = c * x + s * y, c * y - s * x  # the ray in the frame of the outline
                dx = c * rays[2, j] + s * rays[3, j]
                dy = c * rays[3, j] - s * rays[2, j]
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
        """(K, 5): number of the thing; x, y of one end in its frame, and the vector to the other."""

    def __len__(self) -> int:
        """Number of their edges."""
        return len(self._segments)

    def stop(self, rays: FloatArray, ranges: FloatArray, places: FloatArray, steps: float) -> None:
        """Shorten ``ranges`` (N,) in place where an outline is nearer along one of the ``rays`` (5, N).

        ``places`` (C, M, 3) are x, y and theta of the things at C times; from one ray to the next the time advances by
        ``steps`` rows.
        """
        if len(self._segments):
            stop_at_outlines(rays, ranges, places, self._segments, steps)
