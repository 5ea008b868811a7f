"""One speed of the emulated firmware."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, sqrt


@dataclass(slots=True)
class Ramp:
    """The speed, its limit, and the ramps towards what was asked for: another speed, or a way to go; SI units."""

    limit: float
    rise: float
    fall: float
    target: float = 0.0
    speed: float = 0.0
    left: float | None = None
    """Of the way to go; None where a speed was asked for."""

    def ask(self, speed: float) -> None:
        """Set the target, within the limit; a way that is not done is forgotten."""
        self.target, self.left = max(-self.limit, min(self.limit, speed)), None

    def go(self, way: float) -> None:
        """Go so far, and stand."""
        self.left = way

    def set_slope(self, rate: float) -> None:
        """SETA and SETRA: how fast it rises where positive, how fast it falls where negative."""
        if rate > 0.0:
            self.rise = rate
        elif rate < 0.0:
            self.fall = -rate

    def approach(self, seconds: float, free: bool, hardest: float | None) -> None:
        """Come nearer to the target, or to 0 where not ``free``; a reversal stops at zero first.

        ``hardest`` is the deceleration where nothing but standing counts.
        """
        target = (self.target if self.left is None else self._towards_end(seconds)) if free else 0.0
        if self.speed * target < 0.0:
            target = 0.0
        rate = hardest or (self.rise if abs(target) > abs(self.speed) else self.fall)
        step = rate * seconds
        self.speed += max(-step, min(step, target - self.speed))
        if self.left is not None:
            self.left -= self.speed * seconds

    def _towards_end(self, seconds: float) -> float:
        """The speed from which the rest of the way suffices to stop; over the last bit, the one that ends it now."""
        left = self.left or 0.0
        fastest = min(self.limit, sqrt(2.0 * self.fall * abs(left)), abs(left) / seconds)
        return copysign(fastest, left)
