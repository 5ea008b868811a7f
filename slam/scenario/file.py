"""Scenario files, loaded and written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from slam.scenario.schema import Scenario
from slam.scenario.settings import named_code, parse_setting
from slam.scenario.shipped import find_scenario
from slam.scenario.source import ScenarioSource
from slam.scenario.template import ScenarioTemplate
from slam.scenario.texts import texts


def load_template(
    name: str | Path, settings: str | Sequence[str] = (), allow_modules: str | Sequence[str] = ()
) -> ScenarioTemplate:
    """The scenario in this file, or the shipped one of this name, with ``key=value`` settings on top, one or
    several, to draw from.

    What the settings name as ``module:name`` may run; what the file names so is refused, unless ``allow_modules`` has
    its module. Raises ScenarioError: one line that names file, line and key, what is wrong, and what was perhaps meant.
    """
    given = texts(settings)
    return checked_template(name, given, [*texts(allow_modules), *named_code(map(parse_setting, given))])


def load_scenario(
    name: str | Path, settings: str | Sequence[str] = (), allow_modules: str | Sequence[str] = ()
) -> Scenario:
    """The draw of ``load_template`` for the scenario's own seed."""
    return load_template(name, settings, allow_modules).draw()


def read_scenario(name: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """The draw of ``read_template`` for the scenario's own seed."""
    return read_template(name, settings).draw()


def read_template(name: str | Path, settings: str | Sequence[str] = ()) -> ScenarioTemplate:
    """Load a template to look at and not to run: it may name any code, and none of it can be called."""
    return checked_template(name, texts(settings), None)


def checked_template(name: str | Path, settings: Sequence[str], allowed: Sequence[str] | None) -> ScenarioTemplate:
    """Load a template with settings that come from a file: they may name ``allowed`` code only."""
    return ScenarioTemplate(ScenarioSource(find_scenario(name), settings), allowed)


def dump_scenario(scenario: Scenario) -> str:
    """YAML that loads to the same scenario."""
    return yaml.safe_dump(scenario.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
