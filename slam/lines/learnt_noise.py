"""The noise of a lidar's ranges, learnt over its scans.

Along a straight wall 1/r is a sinusoid of the bearing, so that of three neighbouring echoes at equal steps the second
difference u(-1) - 2 cos(step) u(0) + u(+1) of u = 1/r is noise alone, of variance 6 sigma^2 / r^4. Corners, gaps and
clutter give differences of any size; in a scan among chair legs they dominate. So differences are counted over many
scans, by range and by size. Over the logarithm of the size, noise is a peak of known width, and clutter a slowly rising
background. In each half octave of range, the estimated noise is the one for which the counts are most likely: its peak
and the background together.
"""

from functools import lru_cache
from math import erf, frexp, log2, sqrt
from typing import Final, Self

import numpy as np

from slam.compiled import compiled, compiled_on_views
from slam.config import ChiSquareConfig, LineConfig
from slam.lines.range_noise import ROUGHNESS, RangeNoise, noise_of_sensor
from slam.pose import FloatArray
from slam.scan import COS, SIN, LaserScan

NEAREST: Final = 2.0**-4
"""Start of the first band of range, metres."""
BANDS: Final = 18
"""Number of bands, half an octave of range each; the last ends at 32 m. Few beams go farther, and most of these into
clutter."""
OCTAVE: Final = 4
"""Bins of size per octave; the noise is searched at their edges, and between them by a parabola."""
BAND: Final = OCTAVE // 2
"""Bins per band."""
MIDDLE: Final = 2.0 ** (0.5 * BAND / OCTAVE)
"""Ratio of the middle of a band to its start."""
BAND_OF_1_M: Final = int(-log2(NEAREST)) * OCTAVE // BAND
SMALLEST: Final = 2.0**-12
"""Start of the first bin: metres in bands below 1 m, and shares of the band's start in the others. Smaller differences
show the resolution of the ranges instead of noise: on a wall straight ahead all ranges are equal."""
SIZES: Final = 9 * OCTAVE
"""Number of bins, up to 1/8. Larger differences are never noise."""
EDGES: Final = 7 * OCTAVE + 3
"""Edges of bins at which the noise is searched: up to 44 mm near by, 3.7 % far away."""
GROUNDS: Final = (0.1, 0.4, 0.9)
"""Shares of the background in a band; the most likely one is taken."""
MEMORY: Final = 1e4
"""Number of differences per band that are remembered: they determine its noise to 1 %, and come from some fifty
scans."""
PRIOR: Final = 2.5
"""Weight of the initial noise, in differences per band; a scan has about a hundred in a few bands."""
ASSUMED: Final = RangeNoise(0.01, 1.0, 0.01, ROUGHNESS)
"""Initial noise if no sensor is named."""


def named_noise(config: LineConfig | None) -> RangeNoise | None:
    """Return the noise of the sensor in the settings; None if they name none."""
    if not isinstance(config, ChiSquareConfig) or config.sensor is None:
        return None
    return noise_of_sensor(config.sensor, config.bound_sigmas)


def _size(edge: float) -> float:
    """Return the size at an edge of the bins."""
    return float(SMALLEST * 2.0 ** (edge / OCTAVE))


def _peak_of_noise(sigma: float) -> FloatArray:
    """Return the share of each bin, (SIZES,), in all the differences in the bins, if they have this noise only."""
    below = np.array([erf(_size(k) / (sqrt(2.0) * sigma)) for k in range(SIZES + 1)])
    return np.asarray(np.diff(below) / (below[-1] - below[0]))


def _log_likelihood() -> FloatArray:
    """Return the log likelihood of a difference in each bin, by the edge of the noise and the share of the background.

    In the background half of the differences are uniform in metres, and half in octaves.
    """
    sizes = np.array([_size(k) for k in range(SIZES + 1)])
    ground = 0.5 * np.diff(sizes) / (sizes[-1] - sizes[0]) + 0.5 / SIZES
    peaks = np.stack([_peak_of_noise(_size(i)) for i in range(EDGES)])
    return np.hstack([np.log((1.0 - share) * peaks + share * ground).T for share in GROUNDS])


@lru_cache
def _expected_counts(noise: RangeNoise) -> FloatArray:
    """Return PRIOR differences in each band, distributed as this noise has them, (BANDS, SIZES).

    The array must not be written to.
    """
    begins = NEAREST * 2.0 ** (BAND / OCTAVE * np.arange(BANDS))
    alone = noise._replace(floor=0.0)
    sigmas = alone.sigma(np.asarray(begins * MIDDLE, np.float64)) / np.maximum(begins, 1.0)
    return PRIOR * np.stack([_peak_of_noise(sigma) for sigma in sigmas.tolist()])


LOG_LIKELIHOOD: Final = _log_likelihood()
"""Shape (SIZES, GROUNDS x EDGES)."""


class LearntNoise:
    """The noise of one sensor: initially that of its name, or ASSUMED; then learnt from its scans."""

    def __init__(self, counts: FloatArray) -> None:
        self.counts = counts
        """Differences by range and size, (BANDS, SIZES), the whole memory."""

    @classmethod
    def start(cls, config: LineConfig | None = None) -> Self:
        """Begin with the noise that these settings give before the first scan."""
        return cls(_expected_counts(named_noise(config) or ASSUMED).copy())

    def observe(self, scan: LaserScan) -> RangeNoise:
        """Learn from the next scan, and return the most likely noise now."""
        _count_differences(self.counts, scan.ranges, scan.fan, scan.reach)
        return self.noise

    @property
    def noise(self) -> RangeNoise:
        """Most likely noise so far."""
        near, far = _most_likely(self.counts @ LOG_LIKELIHOOD)
        near, slope = _size(near), _size(far) / MIDDLE
        return RangeNoise(near, near / slope, slope, ROUGHNESS)


@compiled
def _count_differences(counts: FloatArray, ranges: FloatArray, fan: FloatArray, reach: tuple[float, float]) -> None:
    """Count the differences of every three neighbouring echoes at equal steps; full bands forget old ones."""
    c_1 = s_1 = u_1 = c_0 = s_0 = u_0 = 0.0
    echoes = 0
    for j in range(len(ranges)):
        if not (reach[0] <= ranges[j] <= reach[1]):
            continue
        c, s, u = fan[COS, j], fan[SIN, j], 1.0 / ranges[j]
        cos_step, sin_step, sin_before = c * c_0 + s * s_0, s * c_0 - c * s_0, s_0 * c_1 - c_0 * s_1
        if echoes >= 2 and abs(sin_step - sin_before) < 0.1 * abs(sin_step):
            difference = abs(u_1 - 2.0 * cos_step * u_0 + u) / (u_0 * u_0 * np.sqrt(6.0))
            band = _quarter_octaves(1.0 / (u_0 * NEAREST)) // BAND
            size = _quarter_octaves(difference / SMALLEST) - BAND * max(band - BAND_OF_1_M, 0)
            if 0 <= band < BANDS and 0 <= size < SIZES:
                counts[band, size] += 1.0
        c_1, s_1, u_1, c_0, s_0, u_0 = c_0, s_0, u_0, c, s, u
        echoes += 1
    for band in range(BANDS):
        total = 0.0
        for size in range(SIZES):
            total += counts[band, size]
        if total > MEMORY:
            for size in range(SIZES):
                counts[band, size] *= MEMORY / total


@compiled_on_views
def _quarter_octaves(x: float) -> int:
    """Return the whole quarters of an octave from 1 to ``x``: a faster logarithm."""
    mantissa, exponent = frexp(x)
    return int(4 * exponent - 4 + (mantissa >= 0.5**0.75) + (mantissa >= 0.5**0.5) + (mantissa >= 0.5**0.25))


@compiled
def _most_likely(scores_on_grounds: FloatArray) -> tuple[float, float]:
    """Return the most likely constant noise, and the most likely noise at 1 m that grows with the range.

    Both are fractional indices of edges; the larger noise applies. ``scores_on_grounds`` (BANDS, GROUNDS x EDGES) is
    the log likelihood of each band.
    """
    scores = np.zeros((BANDS, EDGES))
    for band in range(BANDS):
        for i in range(EDGES):
            scores[band, i] = scores_on_grounds[band, i]
            for k in range(EDGES + i, len(GROUNDS) * EDGES, EDGES):
                scores[band, i] = max(scores[band, i], scores_on_grounds[band, k])
    near, far = np.zeros((BANDS + 1, EDGES)), np.zeros((BANDS + 1, EDGES))
    for band in range(BANDS):  # score of the bands before this one, where the near noise is larger
        beyond = BAND * max(band - BAND_OF_1_M, 0)
        for i in range(EDGES):
            near[band + 1, i] = near[band, i] + scores[band, max(i - beyond, 0)]
    for band in range(BANDS - 1, -1, -1):  # score of this band and later ones, where the far noise is larger
        short = BAND * max(BAND_OF_1_M - band, 0)
        for j in range(EDGES):
            far[band, j] = far[band + 1, j] + scores[band, max(j - short, 0)]
    total, best_i, best_j = np.empty((EDGES, EDGES)), 0, 0
    for i in range(EDGES):
        for j in range(EDGES):
            begin = min(max((i - j) // BAND + 1 + BAND_OF_1_M, 0), BANDS)
            total[i, j] = near[begin, i] + far[begin, j]
            if total[i, j] > total[best_i, best_j]:
                best_i, best_j = i, j
    return best_i + _peak(total[:, best_j].copy(), best_i), best_j + _peak(total[best_i], best_j)


@compiled_on_views
def _peak(values: FloatArray, k: int) -> float:
    """Return the offset from a greatest value to the peak of the parabola through it and its neighbours."""
    if k == 0 or k == len(values) - 1:
        return 0.0
    bend = values[k - 1] - 2.0 * values[k] + values[k + 1]
    return 0.5 * (values[k - 1] - values[k + 1]) / bend if bend < 0.0 else 0.0
