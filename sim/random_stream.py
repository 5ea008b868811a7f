"""Random numbers for compiled code: a stream is one 64-bit number, and each robot has its own.

The k-th number depends only on the start of the stream and on k: splitmix64 (Steele, Lea and Flood, 2014). Normal
numbers are made by the ziggurat of Marsaglia and Tsang (2000) with 256 layers.
"""

from math import erfc, exp, log, pi, sqrt
from typing import Any, Final

import numpy as np

from slam.compiled import compiled_on_views
from slam.pose import FloatArray

GOLDEN: Final = np.uint64(0x9E3779B97F4A7C15)
MIX_1: Final = np.uint64(0xBF58476D1CE4E5B9)
MIX_2: Final = np.uint64(0x94D049BB133111EB)
UNIT: Final = 2.0**-53
TAIL: Final = 3.6541528853610088
"""Right end of the lowest of 256 layers of equal area."""


def _layers() -> FloatArray:
    """Widths of the layers, starting with that of the tail, (257,); 0 at the top."""
    area = TAIL * exp(-0.5 * TAIL * TAIL) + sqrt(pi / 2.0) * erfc(TAIL / sqrt(2.0))
    widths = [area / exp(-0.5 * TAIL * TAIL), TAIL]
    while len(widths) < 256:
        widths.append(sqrt(-2.0 * log(area / widths[-1] + exp(-0.5 * widths[-1] ** 2))))
    return np.array([*widths, 0.0])


WIDTHS: Final = _layers()
HEIGHTS: Final = np.exp(-0.5 * WIDTHS**2)


@compiled_on_views
def mixed(counter: np.uint64) -> np.uint64:
    """Return the 64 random bits at this position in the sequence of all streams."""
    z = counter
    z = (z ^ (z >> np.uint64(30))) * MIX_1
    z = (z ^ (z >> np.uint64(27))) * MIX_2
    return z ^ (z >> np.uint64(31))


@compiled_on_views
def _share(bits: np.uint64) -> float:
    """Return a number in [0, 1), from the upper 53 bits."""
    return float(np.int64(bits >> np.uint64(11)) * UNIT)


@compiled_on_views
def stream_of(seed: int) -> np.uint64:
    """Return the first position of the stream of this seed."""
    return mixed(mixed(np.uint64(seed) * GOLDEN + GOLDEN) ^ MIX_1)


@compiled_on_views
def fill_uniform(stream: np.uint64, numbers: FloatArray) -> np.uint64:
    """Fill an array with uniform numbers in [0, 1), and return the next position in the stream."""
    for k in range(len(numbers)):
        numbers[k] = _share(mixed(stream + GOLDEN * np.uint64(k + 1)))
    return stream + GOLDEN * np.uint64(len(numbers))


@compiled_on_views
def fill_normal(stream: np.uint64, numbers: FloatArray) -> np.uint64:
    """Fill an array with standard normal numbers, and return the next position in the stream."""
    for k in range(len(numbers)):
        numbers[k], stream = next_normal(stream)
    return stream


@compiled_on_views
def next_normal(stream: np.uint64) -> tuple[float, np.uint64]:
    """Return a standard normal number, and the next position in the stream."""
    while True:
        stream += GOLDEN
        bits = mixed(stream)
        layer = np.int64(bits & np.uint64(255))
        z = (2.0 * _share(bits) - 1.0) * WIDTHS[layer]
        if abs(z) < WIDTHS[layer + 1]:
            return z, stream
        stream += GOLDEN
        if layer == 0:
            return _tail(z, stream)
        share = _share(mixed(stream))
        if HEIGHTS[layer] + share * (HEIGHTS[layer + 1] - HEIGHTS[layer]) < exp(-0.5 * z * z):
            return z, stream


@compiled_on_views
def _tail(side: float, stream: np.uint64) -> tuple[float, np.uint64]:
    """Return a number beyond TAIL, on this side of 0, and the next position in the stream (Marsaglia, 1964)."""
    while True:
        x = -log(1.0 - _share(mixed(stream + GOLDEN))) / TAIL
        y = -log(1.0 - _share(mixed(stream + GOLDEN + GOLDEN)))
        stream += GOLDEN + GOLDEN
        if y + y > x * x:
            return np.copysign(TAIL + x, side), stream


@compiled_on_views
def normal(owner: Any) -> float:
    """Draw a standard normal number from the field ``stream`` of a record."""
    number, owner.stream = next_normal(owner.stream)
    return number
