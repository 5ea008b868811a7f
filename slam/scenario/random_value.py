"""Values that are drawn for every seed: ``{uniform: [0.2, 0.6]}`` in place of a plain value."""

from abc import abstractmethod
from collections.abc import Iterator
from hashlib import sha256
from typing import Annotated, Any, Final

import numpy as np
from pydantic import AfterValidator, Field

from slam.config import Section
from slam.scenario.values import NotNegative, Positive, ordered_bounds
from slam.scenario.yaml_file import KeyPath

Whole = Annotated[int, Field(ge=-(2**62), le=2**62)]
"""Whole number that numpy can draw."""


class _RandomSection(Section):
    """A section with one key: the bounds or the choices of a random value."""

    @property
    def extremes(self) -> tuple[Any, ...]:
        """Values that the schema must accept: both bounds, or every choice."""
        (values,) = dict(self).values()
        return tuple(values)

    @abstractmethod
    def draw(self, rng: np.random.Generator) -> Any:
        """Draw one value."""


class Uniform(_RandomSection):
    """A number between two bounds."""

    uniform: Annotated[tuple[float, float], AfterValidator(ordered_bounds)]
    """The bounds."""

    def draw(self, rng: np.random.Generator) -> Any:
        return float(rng.uniform(*self.uniform))


class Integer(_RandomSection):
    """A whole number between two bounds, both included."""

    integer: Annotated[tuple[Whole, Whole], AfterValidator(ordered_bounds)]
    """The bounds."""

    def draw(self, rng: np.random.Generator) -> Any:
        return int(rng.integers(*self.integer, endpoint=True))


class Normal(_RandomSection):
    """A normally distributed number, at most three standard deviations from the mean."""

    normal: tuple[float, NotNegative]
    """The mean, and the standard deviation."""

    @property
    def extremes(self) -> tuple[Any, ...]:
        """Three standard deviations below and above the mean."""
        mean, sigma = self.normal
        return mean - 3.0 * sigma, mean + 3.0 * sigma

    def draw(self, rng: np.random.Generator) -> Any:
        while abs(deviation := rng.standard_normal()) > 3.0:
            pass
        mean, sigma = self.normal
        return float(mean + sigma * deviation)


class LogUniform(_RandomSection):
    """A number between two bounds above 0, with every order of magnitude equally likely."""

    loguniform: Annotated[tuple[Positive, Positive], AfterValidator(ordered_bounds)]
    """The bounds."""

    def draw(self, rng: np.random.Generator) -> Any:
        low, high = self.loguniform
        return float(np.clip(np.exp(rng.uniform(np.log(low), np.log(high))), low, high))


class Choice(_RandomSection):
    """One of several values, equally likely."""

    choice: tuple[Any, ...] = Field(min_length=1)
    """The values; one that occurs twice is twice as likely."""

    def draw(self, rng: np.random.Generator) -> Any:
        return self.choice[rng.integers(len(self.choice))]


RandomValue = Uniform | Integer | Normal | LogUniform | Choice
KINDS: Final[dict[str, type[RandomValue]]] = {
    "uniform": Uniform, "integer": Integer, "normal": Normal, "loguniform": LogUniform, "choice": Choice,
}  # fmt: skip
"""Kinds by the key of a random value. No section of a scenario has a key of such a name."""


def is_random(data: Any) -> bool:
    """Return True for data of a random value."""
    return isinstance(data, dict) and len(data) == 1 and next(iter(data)) in KINDS


def find_random(data: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, type[RandomValue], Any]]:
    """Find the random values in nested YAML data: path, kind, and the data."""
    if is_random(data):
        yield path, KINDS[next(iter(data))], data
    elif isinstance(data, dict | list):
        for step, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from find_random(value, (*path, step))


def key_rng(path: KeyPath, *seeds: int) -> np.random.Generator:
    """Make the random numbers of one key, independent of every other key, the same in every process."""
    digest = sha256(".".join(map(str, path)).encode()).digest()
    return np.random.default_rng([*seeds, int.from_bytes(digest[:8])])
