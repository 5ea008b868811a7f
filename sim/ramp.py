"""How the controller of the base approaches the speed that was asked for."""

from __future__ import annotations


def ramped(speed: float, target: float, rise: float, fall: float) -> float:
    """The speed one step later: it grows by at most ``rise`` and shrinks by at most ``fall``.

    A reversal goes through zero: it falls first and rises afterwards.
    """
    if speed * target < 0.0:
        target = 0.0
    largest = rise if abs(target) > abs(speed) else fall
    if abs(target - speed) <= largest:
        return target
    return speed + largest if target > speed else speed - largest
