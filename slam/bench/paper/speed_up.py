"""How much hopping should gain: eqs. (13) and (14)."""

from __future__ import annotations

from collections.abc import Callable


def hops(n: int, psi: int) -> tuple[int, int]:
    """(h_major, h_total) of a segment of n points, eq. (14): the long hops, and all hops."""
    h_major, h_minor = divmod(n - 1, psi + 1)
    return h_major, h_major + h_minor


def predicted_speed_up(n: int, psi: int, t: Callable[[int], float] = float) -> float:
    """Eq. (13): tests of n points one by one over tests with hops of psi; ``t`` is the time of a test of so many
    points, by default in proportion to them, as the values of an SVD are.

    The last sum is taken as printed: it counts short hops by their number, not by the points that they test.
    """
    h_major, h_total = hops(n, psi)
    every_point = sum(t(j) for j in range(1, n))
    long_hops = sum(t(1 + (j - 1) * (psi + 1)) for j in range(1, h_major + 1))
    short_hops = sum(t(j) for j in range(h_major + 1, h_total + 1))
    return every_point / (long_hops + short_hops)
