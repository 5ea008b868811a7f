"""Scenarios of the episodes of an environment, and the options of ``reset``, which change one episode."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import ValidationError

from slam.env.config import EnvConfig
from slam.errors import InputError, ScenarioError, did_you_mean
from slam.pose import Pose2D
from slam.scenario.checks import find_obstruction
from slam.scenario.file import load_template
from slam.scenario.schema import Scenario
from slam.scenario.settings import one_or_several
from slam.scenario.template import ScenarioTemplate
from slam.scenario.validation_message import validation_message
from slam.scenario.values import Place

_KEYS = ("start", "goal", "settings")


@dataclass(frozen=True, slots=True)
class ResetOptions:
    """Start of the robot, a single way-point as its goal, and additional settings of the scenario."""

    start: Place | None = None
    goal: Place | None = None
    settings: tuple[str, ...] = ()

    @classmethod
    def of(cls, options: Mapping[str, Any] | None) -> Self:
        """Check the options of ``reset``; InputError names an unknown key, or the fault of a value."""
        given = options or {}
        if not isinstance(given, Mapping):
            raise InputError(f"options={options!r}: give a dict with any of the keys {', '.join(_KEYS)}")
        for key in given:
            if key not in _KEYS:
                raise InputError(f"options: no option {key!r}; {did_you_mean(str(key), _KEYS)}")
        start, goal = given.get("start"), given.get("goal")
        return cls(
            None if start is None else _place("start", start, (2, 3)),
            None if goal is None else _place("goal", goal, (2,)),
            _settings(given.get("settings") or ()),
        )

    def applied(self, scenario: Scenario) -> Scenario:
        """Put this start and goal into the scenario; ScenarioError if a solid occupies one of them."""
        if self.start is None and self.goal is None:
            return scenario
        robot, route = scenario.robot, scenario.route
        if self.start is not None:
            robot = robot.model_copy(update={"start": self.start})
        if self.goal is not None:
            route = route.model_copy(update={"waypoints": ((self.goal.x, self.goal.y),)})
        changed = scenario.model_copy(update={"robot": robot, "route": route})
        if (blocked := find_obstruction(changed)) is not None:
            key_path, problem = blocked
            raise ScenarioError(f"options: {'start' if key_path[0] == 'robot' else 'goal'}: {problem}")
        return changed


def _settings(given: Any) -> tuple[str, ...]:
    settings = one_or_several(given)
    if isinstance(given, Mapping) or not all(isinstance(setting, str) for setting in settings):
        raise InputError(f"options: settings={given!r}: give 'key=value', or a list of such strings")
    return settings


def _place(name: str, value: Any, counts: tuple[int, ...]) -> Place:
    form = " or ".join(("[x, y]", "[x, y, theta]")[count - 2] for count in counts)
    given = (value.x, value.y, value.theta) if isinstance(value, Pose2D | Place) else value
    try:
        numbers = np.asarray(given, np.float64)
        if numbers.ndim == 1 and len(numbers) in counts:
            return Place(**dict(zip(("x", "y", "theta"), numbers.tolist(), strict=False)))
    except (TypeError, ValueError) as error:
        why = _number_error(error) if isinstance(error, ValidationError) else "no numbers"
        raise InputError(f"options: {name}={value!r}: {why}; give {form}, metres and radians, map frame") from error
    raise InputError(f"options: {name}={value!r}: give {form}, metres and radians, map frame")


def _number_error(error: ValidationError) -> str:
    """Name the wrong number, and why it is wrong."""
    (number,), reason = validation_message(error, Place)
    return f"{number}: {reason}"


class EpisodeScenarios:
    """Draws scenarios from a file, given by name or path with additional settings; a Scenario value does not change."""

    def __init__(
        self,
        scenario: str | Path | Scenario,
        settings: str | Sequence[str],
        allow_modules: str | Sequence[str],
        config: EnvConfig,
    ) -> None:
        self._config = config
        self._given, self._settings = scenario, one_or_several(settings)
        self._allow_modules = one_or_several(allow_modules)
        self._template: ScenarioTemplate | None = None
        if isinstance(scenario, Scenario) and not self._settings:
            self.first = scenario
            """Scenario of the file's own seed."""
        else:
            self._template = self._load()
            self.first = self._template.draw()
        config.require_route(self.first)

    def draw(self, seed: int | None, options: ResetOptions) -> Scenario:
        """Make the scenario of an episode with this seed, or with the file's own.

        It is the object ``first`` if neither options nor the seed change anything.
        """
        if options.settings:
            scenario = self._load(options.settings).draw(seed)
        elif self._template is None or not self._template.random:
            scenario = self.first
        else:
            scenario = self._template.draw(seed)
        scenario = options.applied(scenario)
        if scenario.lidar.description != self.first.lidar.description:
            raise ScenarioError(f"{scenario.name}: lidar.model cannot change, nor be random: spaces stay as they are")
        self._config.require_route(scenario)
        return scenario

    def draw_pool(self, count: int | None) -> list[Scenario]:
        """Draw ``count`` scenarios, by default 64, the first with the file's own seed; one if nothing is random."""
        if self._template is None or not self._template.random:
            return [self.first]
        return [self.draw(self.first.seed + k, ResetOptions()) for k in range(count or 64)]

    def _load(self, more: tuple[str, ...] = ()) -> ScenarioTemplate:
        """Load the file, with more settings; ScenarioError for a Scenario value, which takes none."""
        settings = self._settings + more
        if isinstance(self._given, Scenario):
            raise ScenarioError(
                f"settings={list(settings)}: the scenario is a value here; change it, or give its name or file instead"
            )
        return load_template(self._given, settings, self._allow_modules)
