"""Scenario files: reading, writing, and a short description."""

from collections.abc import Sequence
from itertools import pairwise
from math import dist
from pathlib import Path

import yaml

from slam.scenario.schema import Scenario
from slam.scenario.settings import named_code, one_or_several, parse_setting
from slam.scenario.shipped import find_scenario
from slam.scenario.source import ScenarioSource
from slam.scenario.template import ScenarioTemplate


def load_template(
    name: str | Path, settings: str | Sequence[str] = (), allow_modules: str | Sequence[str] = ()
) -> ScenarioTemplate:
    """Load the template in this file, or the shipped one with this name.

    ``settings``, one or several ``key=value``, override it.

    Code that the settings name as ``module:name`` may run; code that the file names may not, unless ``allow_modules``
    has its module. Raises ScenarioError: one line with file, line and key, the fault, and a suggestion.
    """
    given = one_or_several(settings)
    return checked_template(name, given, [*one_or_several(allow_modules), *named_code(map(parse_setting, given))])


def load_scenario(
    name: str | Path, settings: str | Sequence[str] = (), allow_modules: str | Sequence[str] = ()
) -> Scenario:
    """Load a template, and draw a scenario by the template's own seed."""
    return load_template(name, settings, allow_modules).draw()


def read_scenario(name: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """Read a template, and draw a scenario by the template's own seed."""
    return read_template(name, settings).draw()


def read_template(name: str | Path, settings: str | Sequence[str] = ()) -> ScenarioTemplate:
    """Load a template for display: it may name any code, but none of it can run."""
    return checked_template(name, one_or_several(settings), None)


def checked_template(name: str | Path, settings: Sequence[str], allowed: Sequence[str] | None) -> ScenarioTemplate:
    """Load a template from a file, and override it by ``settings``; both may name ``allowed`` code only."""
    return ScenarioTemplate(ScenarioSource(find_scenario(name), settings), allowed)


def dump_scenario(scenario: Scenario) -> str:
    """Format the scenario as YAML that loads to the same scenario."""
    return yaml.safe_dump(scenario.model_dump(mode="json"), sort_keys=False, allow_unicode=True)


def summary(scenario: Scenario) -> str:
    """Describe name and purpose, then the world, the people and the route, one line each."""
    length = sum(dist(a, b) for a, b in pairwise(scenario.path))
    return "\n".join(
        [
            f"{scenario.name}: {scenario.description}" if scenario.description else scenario.name,
            f"world: {_world_summary(scenario)}",
            f"people: {len(scenario.people)}",
            f"route: {length:.1f} m over {len(scenario.route.waypoints)} way-points; seed {scenario.seed}",
        ]
    )


def _world_summary(scenario: Scenario) -> str:
    if (bounds := scenario.world.bounds()) is None:
        return "empty"
    width, depth = bounds[1] - bounds[0]
    height = scenario.lidar.height
    solids, seen = len(scenario.world.prisms()), len(scenario.world.outlines(height))
    return f"{width:.1f} m by {depth:.1f} m, {solids} solids, {seen} of them cut by the lidar's plane at {height:g} m"
