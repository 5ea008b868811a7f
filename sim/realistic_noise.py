"""Errors of a real URG-04LX: from the returned light, at edges, and during warm-up.

The effects are those that Kneip et al., "Characterization of the compact Hokuyo URG-04LX 2D laser range scanner", ICRA
2009, and Okubo, Ye and Borenstein, "Characterization of the Hokuyo URG-04LX laser rangefinder for mobile robot obstacle
negotiation", 2009, describe. Both find that the figures depend so much on the target that no one table holds for all.
The formulas follow from how such a sensor works; the constants are this project's choice.
"""

from math import cos, exp, sin
from typing import Final

import numpy as np

from slam.compiled import compiled
from slam.pose import FloatArray

SIGMA_NEAR: Final = 0.003
"""Noise of the sensor's electronics, metres, the part that more returned light does not reduce. Our choice."""
SIGMA_LIGHT: Final = 0.0033
"""Shot noise for white paper at 1 m, metres: a third of the data sheet's 1 %, so that 3 sigma stay within it."""
DARK: Final = 0.01
"""Light at which the share of lost echoes is 1/e, relative to white paper at 1 m. Our choice."""
BEAM_HALF_WIDTH: Final = 0.005
"""Beam divergence, radians: the beam is 40 mm wide at 4 m (recalled from the data sheet), more than the beam
spacing."""
EDGE: Final = 0.05
"""Two neighbouring ranges that differ by more, and are not of one plane, have an edge between; metres. Our choice."""
WARM_UP: Final = 0.010
"""Excess of the ranges at power-up, metres; our choice, of the size that is reported."""
WARM_UP_TIME: Final = 1200.0
"""Time constant of the excess's decay, seconds."""


@compiled
def realistic_ranges(
    ranges: FloatArray, step: float, time: float, reflectivity: float,
    normal: FloatArray, lost: FloatArray, edge: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return ranges (N,) with errors; nan if too little light came back.

    ``step`` is the angle between two beams, radians. ``normal`` (N,) are standard normal draws, ``lost`` and ``edge``
    (N,) uniform draws from 0 to 1.
    """
    cosines = incidence(ranges, step)
    mixed = mixed_pixels(ranges, step, edge)
    drift = WARM_UP * exp(-time / WARM_UP_TIME)
    noisy = np.empty(len(ranges))
    for j in range(len(ranges)):
        if not mixed[j] < np.inf:
            noisy[j] = np.inf
            continue
        light = reflectivity * cosines[j] / (mixed[j] * mixed[j] + 1e-12)  # a matt surface: Lambert's law
        if lost[j] < exp(-light / DARK):
            noisy[j] = np.nan
        else:  # shot noise: the variance goes as 1 / light
            noisy[j] = mixed[j] + drift + normal[j] * np.sqrt(SIGMA_NEAR**2 + SIGMA_LIGHT**2 / light)
    return noisy


@compiled
def incidence(ranges: FloatArray, step: float) -> FloatArray:
    """Return the cosine of the angle between each beam and the normal of the surface, (N,).

    The surface is the chord to the neighbouring point with the smaller range difference; a beam without neighbours
    counts as perpendicular.
    """
    cosines = np.ones(len(ranges))
    for j in range(len(ranges)):
        r, jump = ranges[j], np.inf
        for n in (j - 1, j + 1):
            if 0 <= n < len(ranges) and abs(ranges[n] - r) < jump:
                jump = abs(ranges[n] - r)
                chord = np.sqrt(r * r + ranges[n] * ranges[n] - 2.0 * r * ranges[n] * cos(step))
                cosines[j] = max(ranges[n] * sin(step) / max(chord, 1e-12), 1e-3)
    return cosines


@compiled
def mixed_pixels(ranges: FloatArray, step: float, edge: FloatArray) -> FloatArray:
    """Return ranges (N,) in which a beam across an edge gets the mean of both surfaces, weighted by their light.

    The position of an edge between beams j and j + 1 is unknown: it is drawn as the share ``edge[j]`` (0 to 1) of the
    beam spacing.
    """
    mixed = ranges.copy()
    for j in range(len(ranges) - 1):
        a, b = ranges[j], ranges[j + 1]
        if not (a < np.inf and b < np.inf and abs(a - b) > EDGE):
            continue
        before = ranges[j - 1] if j > 0 else np.inf
        after = ranges[j + 2] if j + 2 < len(ranges) else np.inf
        bend = 2.0 * cos(step)  # on a plane, 1/r of three neighbours obeys u + w = bend v
        if abs(1.0 / (bend / a - 1.0 / before) - b) < EDGE or abs(1.0 / (bend / b - 1.0 / after) - a) < EDGE:
            continue
        for beam, own, other, away in ((j, a, b, edge[j]), (j + 1, b, a, 1.0 - edge[j])):
            over = (BEAM_HALF_WIDTH - away * abs(step)) / (2.0 * BEAM_HALF_WIDTH)  # share of the beam beyond the edge
            if over > 0.0:
                light_own, light_other = (1.0 - over) / (own * own), over / (other * other)
                mixed[beam] = (light_own * own + light_other * other) / (light_own + light_other)
    return mixed
