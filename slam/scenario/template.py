"""A scenario before its random values are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from pydantic import ValidationError

from slam.config.section import ALLOWED
from slam.scenario.cautions import cautions
from slam.scenario.generators.build import built
from slam.scenario.obstruction import obstruction
from slam.scenario.random_value import RandomValue, filled, find_random, key_rng
from slam.scenario.schema import Scenario
from slam.scenario.source import ScenarioSource
from slam.scenario.validation_message import validation_message
from slam.scenario.yaml_file import Location

_ATTEMPTS: Final = 50
"""Number of draws of a scenario in which a solid stands where the robot is to be, before it is an error."""


class ScenarioTemplate:
    """What a scenario file says: ``draw(seed)`` makes a scenario of it.

    All random values are checked at both ends of their range, each with the others at their first end. Raises
    ScenarioError, which names file, line and key. ``allowed`` are the modules and ``module:name`` places whose code the
    user allows; any other that is named is refused. None: they may be named, and cannot be called.
    """

    def __init__(self, source: ScenarioSource, allowed: Sequence[str] | None) -> None:
        self._source = source
        self._context = {"folder": source.folder} | ({} if allowed is None else {ALLOWED: tuple(allowed)})
        self._random = self._find_random()
        self.seed = self._checked_extremes().seed
        """The seed that the file gives, or 0."""
        self._first = self._draw(self.seed)

    @property
    def random(self) -> bool:
        """Whether draws of different seeds differ in more than ``Scenario.seed``."""
        return bool(self._random)

    def draw(self, seed: int | None = None) -> Scenario:
        """The scenario of this seed, or of the file's own: the same in every process.

        Each random value depends on the seed and its own key only. Where a solid then stands at the start or at a
        way-point, all are drawn again; ScenarioError after 50 times.
        """
        if seed is None or seed == self.seed:
            return self._first
        return self._draw(seed) if self.random else self._first.model_copy(update={"seed": seed})

    def cautions(self, scenario: Scenario) -> list[str]:
        """Warnings about strange values of a scenario that was drawn; each names file, line and key."""
        return [str(self._source.error(key, reason)) for key, reason in cautions(scenario)]

    def _draw(self, seed: int, attempt: int = 0) -> Scenario:
        values = {path: value.draw(key_rng(path, seed, attempt)) for path, value in self._random.items()}
        scenario = built(self._validated(values | {("seed",): seed}))
        blocked = obstruction(scenario)
        if blocked is None:
            return scenario
        if self.random and attempt + 1 < _ATTEMPTS:
            return self._draw(seed, attempt + 1)
        key, problem = blocked
        drawn = f", and so it was in {_ATTEMPTS} draws of seed {seed}" if self.random else ""
        raise self._source.error(key, problem + drawn)

    def _find_random(self) -> dict[Location, RandomValue]:
        """The random values by their paths; a generator without a seed of its own gets a random one."""
        generate = self._source.data.get("generate")
        if isinstance(generate, dict) and "kind" in generate:
            generate.setdefault("seed", {"integer": [0, 2**31]})
        return {path: self._parsed(path, kind, text) for path, kind, text in find_random(self._source.data)}

    def _parsed(self, path: Location, kind: type[RandomValue], text: Any) -> RandomValue:
        if path in {("seed",), ("name",)}:
            raise self._source.error(path, f"cannot be random (got {text!r})")
        try:
            return kind.model_validate(text)
        except ValidationError as errors:
            _, reason = validation_message(errors, kind)
            raise self._source.error(path, f"{next(iter(text))}: {reason}") from errors

    def _checked_extremes(self) -> Scenario:
        """The scenario with every random value at its first end, when it is valid at the other ends too."""
        lowest = {path: value.extremes[0] for path, value in self._random.items()}
        scenario = self._validated(lowest)
        for path, value in self._random.items():
            for extreme in value.extremes[1:]:
                self._validated(lowest | {path: extreme})
        return scenario

    def _validated(self, values: dict[Location, Any]) -> Scenario:
        """The scenario with these values in place of what the file has there."""
        data = filled({"seed": 0} | self._source.data, values)
        try:
            return Scenario.model_validate(data, context=self._context)
        except ValidationError as errors:
            location, reason = validation_message(errors, Scenario)
            raise self._source.error(location, reason) from errors
