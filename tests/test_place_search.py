"""The bounded search of a place in a submap: its bounds against plain maxima."""

import numpy as np

from slam.graph.place_search import BLOCK, Pictures, _bounds, _pooled
from slam.lines.segments import IntArray

SIZE, BLOCKS = 30, 6


def drawn() -> Pictures:
    pictures = np.random.default_rng(0).integers(0, 64, (9, SIZE, SIZE + 1), np.uint8)
    return Pictures(pictures, _pooled(pictures), 0.0, 0.0)


def some_shifts() -> IntArray:
    """Some that begin before the picture, some that end behind it."""
    random = np.random.default_rng(1)
    rows_columns = random.integers(-2 * BLOCK * BLOCKS, SIZE + 5, (3, 40, 2))
    return np.concatenate([random.integers(0, 9, (3, 40, 1)), rows_columns], axis=2)


def test_pooled_pictures_hold_the_maxima_of_blocks() -> None:
    pictures = drawn()
    for row, column in ((0, 0), (5, 3), (SIZE - BLOCK, SIZE + 1 - BLOCK)):
        block = pictures.drawn[:, row : row + BLOCK, column : column + BLOCK]
        pooled = pictures.pooled[:, column % BLOCK, row, column // BLOCK]
        assert (pooled == block.max(axis=(1, 2))).all()


def test_bounds_are_sums_of_maxima_inside_of_the_picture() -> None:
    pictures, shifts = drawn(), some_shifts()
    found = _bounds(shifts, pictures, BLOCKS)
    plain = np.zeros(found.shape, np.int64)
    for a, i, j in np.ndindex(plain.shape):
        for side, row, column in shifts[a]:
            y, x = row + i * BLOCK, column + j * BLOCK
            if 0 <= y < SIZE and 0 <= x <= SIZE:
                plain[a, i, j] += pictures.pooled[side, x % BLOCK, y, x // BLOCK]
    assert (found == plain).all()
    assert found.any()
