"""The search of a place in a submap: its bounds and its best places, compared with plain loops."""

import numpy as np
import pytest

from slam.graph.place_search import BLOCK, Pictures, Window, _best_of_blocks, _bounds, _pooled
from slam.lines.segments import IntArray
from slam.matching.coarse_search import FULL_GREY, HEADING, HEADING_STEP, PIXEL, PLACE_X, PLACE_Y, SCORE

SIZE, BLOCKS = 30, 6


def drawn() -> Pictures:
    pictures = np.random.default_rng(0).integers(0, 64, (9, SIZE, SIZE + 1), np.uint8)
    return Pictures(pictures, _pooled(pictures), 0.0, 0.0)


def some_shifts() -> IntArray:
    """Draw shifts, some of which begin before the picture or end behind it."""
    random = np.random.default_rng(1)
    rows_columns = random.integers(-2 * BLOCK * BLOCKS, SIZE + 5, (3, 40, 2))
    return np.concatenate([random.integers(0, 9, (3, 40, 1)), rows_columns], axis=2)


def test_pooled_pictures_hold_the_maxima_of_blocks() -> None:
    pictures = drawn()
    for row, column in ((0, 0), (5, 3), (SIZE - BLOCK, SIZE + 1 - BLOCK)):
        block = pictures.drawn[:, row : row + BLOCK, column : column + BLOCK]
        pooled = pictures.pooled[:, column % BLOCK, row, column // BLOCK]
        assert (pooled == block.max(axis=(1, 2))).all()


def test_bounds_are_sums_of_maxima_inside_the_picture() -> None:
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


def test_the_best_place_of_a_block_equals_a_plain_search() -> None:
    """Facets outside the picture do not count; the cost of the prior is subtracted."""
    pictures, shifts = drawn(), some_shifts()
    window = Window(np.array([1.0, -2.0, 0.3]), np.diag([0.4, 0.2, 5.0]), 10, 1)
    blocks = (2 * window.half_width + BLOCK) // BLOCK
    chosen = np.array([0, 8, blocks * blocks + 13, 3 * blocks * blocks - 1])
    places, shares = _best_of_blocks(chosen, blocks, shifts, pictures.drawn, window)
    for block, place, share in zip(chosen.tolist(), places, shares, strict=True):
        a, i0, j0 = np.unravel_index(block, (3, blocks, blocks))
        best: tuple[float, ...] = (-np.inf,)
        for i in range(BLOCK * i0, min(BLOCK * (i0 + 1), 2 * window.half_width + 1)):
            for j in range(BLOCK * j0, min(BLOCK * (j0 + 1), 2 * window.half_width + 1)):
                total = 0.0
                for side, row, column in shifts[a] + np.array([0, i, j]):
                    total += pictures.drawn[side, row, column] if 0 <= row < SIZE and 0 <= column <= SIZE else 0.0
                off = np.array([PIXEL * (j - 10), PIXEL * (i - 10), HEADING_STEP * (a - 1)])
                found = total / (FULL_GREY * shifts.shape[1])
                best = max(best, (found - 0.5 * off @ window.information @ off, found, *(window.prior + off)))
        assert place[SCORE] == pytest.approx(best[0])
        assert share == pytest.approx(best[1])
        assert place[[PLACE_X, PLACE_Y, HEADING]] == pytest.approx(best[2:])
