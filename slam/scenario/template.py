"""A scenario before its random values are drawn."""

from collections.abc import Sequence
from typing import Any, Final

from pydantic import ValidationError

from slam.config.section import ALLOWED
from slam.scenario.checks import find_obstruction, find_warnings
from slam.scenario.random_value import RandomValue, find_random, key_rng
from slam.scenario.schema import Scenario
from slam.scenario.source import ScenarioSource
from slam.scenario.validation_message import validation_message
from slam.scenario.yaml_file import KeyPath

_ATTEMPTS: Final = 50
"""Number of draws before giving up, if each puts a solid at the robot's start or at a way-point."""


class ScenarioTemplate:
    """A scenario file as read: ``draw(seed)`` makes a scenario of it.

    Each random value is checked at both ends of its range, while all others are at their first end. Raises
    ScenarioError, with file, line and key. ``allowed`` are the modules and ``module:name`` places whose code the user
    allows; other code is refused. If it is None, the scenario may name any code, but none can run.
    """

    def __init__(self, source: ScenarioSource, allowed: Sequence[str] | None) -> None:
        self._source = source
        self._context = {"folder": source.folder} | ({} if allowed is None else {ALLOWED: tuple(allowed)})
        self._random = self._find_random()
        self.seed = self._checked_extremes().seed
        """The seed in the file, or 0."""
        self._first = self._draw(self.seed)

    @property
    def random(self) -> bool:
        """True if draws of different seeds differ in more than ``Scenario.seed``."""
        return bool(self._random)

    def draw(self, seed: int | None = None) -> Scenario:
        """Draw the scenario of this seed, or of the file's own: the same in every process.

        Each random value depends on the seed and its own key only. If a solid then occupies the start or a way-point,
        all are drawn again; ScenarioError after 50 times.
        """
        if seed is None or seed == self.seed:
            return self._first
        return self._draw(seed) if self.random else self._first.model_copy(update={"seed": seed})

    def warnings(self, scenario: Scenario) -> list[str]:
        """Warn of strange values of a drawn scenario, one line each, with file, line and key."""
        return [str(self._source.error(key, reason)) for key, reason in find_warnings(scenario)]

    def _draw(self, seed: int) -> Scenario:
        for attempt in range(_ATTEMPTS if self.random else 1):
            values = {path: value.draw(key_rng(path, seed, attempt)) for path, value in self._random.items()}
            scenario = _with_generated(self._validated(values | {("seed",): seed}))
            obstruction = find_obstruction(scenario)
            if obstruction is None:
                return scenario
            key, problem = obstruction
        drawn = f", and so it was in {_ATTEMPTS} draws of seed {seed}" if self.random else ""
        raise self._source.error(key, problem + drawn)

    def _find_random(self) -> dict[KeyPath, RandomValue]:
        """Find the random values, by their paths; a generator without a seed of its own gets a random one."""
        generate = self._source.data.get("generate")
        if isinstance(generate, dict) and "kind" in generate:
            generate.setdefault("seed", {"integer": [0, 2**31]})
        return {path: self._parsed(path, kind, text) for path, kind, text in find_random(self._source.data)}

    def _parsed(self, path: KeyPath, kind: type[RandomValue], text: Any) -> RandomValue:
        if path in {("seed",), ("name",)}:
            raise self._source.error(path, f"cannot be random (got {text!r})")
        try:
            return kind.model_validate(text)
        except ValidationError as errors:
            _, reason = validation_message(errors, kind)
            raise self._source.error(path, f"{next(iter(text))}: {reason}") from errors

    def _checked_extremes(self) -> Scenario:
        """Make the scenario with every random value at its first end; it must also be valid at the other ends."""
        lowest = {path: value.extremes[0] for path, value in self._random.items()}
        scenario = self._validated(lowest)
        for path, value in self._random.items():
            for extreme in value.extremes[1:]:
                self._validated(lowest | {path: extreme})
        return scenario

    def _validated(self, values: dict[KeyPath, Any]) -> Scenario:
        """Make the scenario with these values instead of the random ones."""
        data = _with_values({"seed": 0} | self._source.data, values)
        try:
            return Scenario.model_validate(data, context=self._context)
        except ValidationError as errors:
            key_path, reason = validation_message(errors, Scenario)
            raise self._source.error(key_path, reason) from errors


def _with_values(data: Any, values: dict[KeyPath, Any], path: KeyPath = ()) -> Any:
    """Copy nested data with these values at their paths; ``data`` does not change."""
    if path in values:
        return values[path]
    if isinstance(data, dict):
        return {step: _with_values(value, values, (*path, step)) for step, value in data.items()}
    if isinstance(data, list):
        return [_with_values(value, values, (*path, step)) for step, value in enumerate(data)]
    return data


def _with_generated(scenario: Scenario) -> Scenario:
    """Add the generated world and people to those of the scenario.

    Its own way-points and start pose are kept. The result has no generator, and is therefore complete: its file stays
    the same even if a later version generates something else.
    """
    if scenario.generate is None:
        return scenario
    made, robot, route = scenario.generate.build(), scenario.robot, scenario.route
    changed: dict[str, Any] = {
        "generate": None, "world": scenario.world.joined(made.world), "people": scenario.people + made.people,
    }  # fmt: skip
    if "start" not in robot.model_fields_set:
        changed["robot"] = robot.model_copy(update={"start": made.start})
    if "waypoints" not in route.model_fields_set:
        changed["route"] = route.model_copy(update={"waypoints": made.waypoints})
    return scenario.model_copy(update=changed)
