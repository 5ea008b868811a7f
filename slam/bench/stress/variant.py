"""A way to make a log harder: faults by their names, one after another."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from slam.bench.stress import scan_faults, wheel_faults
from slam.bench.stress.mending import mended
from slam.errors import InputError
from slam.files.logs import Log
from slam.pose import FloatArray

MEND: Final = "mend"
"""Begins a variant whose odometry is mended by the log's reference first."""
_FAULTS: Final[dict[str, Callable[[Log, float, np.random.Generator], Log]]] = {
    "every": scan_faults.every_nth,
    "beams": scan_faults.every_nth_beam,
    "coarse": scan_faults.coarse_ranges,
    "noise": scan_faults.noisy_ranges,
    "scatter": scan_faults.scattered_ranges,
    "jitter": wheel_faults.jittering_wheels,
    "scale": wheel_faults.misjudging_wheels,
    "slips": wheel_faults.slipping_wheels,
    "blind": wheel_faults.silent_wheels,
    "stale": wheel_faults.stale_wheels,
}
_FIXED: Final = frozenset({"every", "beams", "coarse"})
"""Faults in which nothing is drawn."""
_WHOLE: Final = frozenset({"every", "beams", "slips", "blind"})
"""Faults whose value is a whole number from 1 on."""


@dataclass(frozen=True, slots=True)
class Variant:
    """What is done to a log; ``str`` of it is what ``parse`` reads, as ``mend,every=5,blind=10``."""

    faults: tuple[tuple[str, float], ...]
    """Name and value of each, in the order in which they are applied."""
    mend: bool = False

    @classmethod
    def parse(cls, text: str) -> Self:
        """The variant of this text; InputError, saying what is needed, for another one."""
        words = text.split(",")
        mend = words[0] == MEND
        return cls(tuple(_fault(word) for word in words[mend:]), mend)

    def __str__(self) -> str:
        """The variant in words."""
        return ",".join([MEND] * self.mend + [f"{name}={value:g}" for name, value in self.faults])

    @property
    def random(self) -> bool:
        """True where another seed makes another log."""
        return any(name not in _FIXED for name, _ in self.faults)

    def unspoilt(self, log: Log, times: FloatArray, truth: FloatArray) -> Log:
        """The log before the faults: mended by its reference where the variant says so."""
        return mended(log, times, truth) if self.mend else log

    def spoilt(self, log: Log, seed: int) -> Log:
        """The log after the faults; the same one for the same seed."""
        for number, (name, value) in enumerate(self.faults):
            log = _FAULTS[name](log, value, np.random.default_rng([seed, number]))
        return log


def _fault(word: str) -> tuple[str, float]:
    name, _, number = word.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    if name not in _FAULTS or not 0.0 < value < np.inf or (name in _WHOLE and value % 1.0):
        need = f"need NAME=NUMBER above 0, parted by commas, of {', '.join(_FAULTS)}; {MEND} may stand before them"
        raise InputError(f"variant {word!r}: {need}")
    return name, value
