"""Scenario files, loaded and written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from slam.run.scenario.schema import Scenario
from slam.run.scenario.shipped import find_scenario
from slam.run.scenario.source import ScenarioSource
from slam.run.scenario.template import ScenarioTemplate


def load_template(name: str | Path, settings: str | Sequence[str] = ()) -> ScenarioTemplate:
    """The scenario in this file, or the shipped one of this name, with ``key=value`` settings on top, one or
    several, to draw from.

    Raises ScenarioError: one line that names file, line and key, what is wrong, and what was perhaps meant.
    """
    return ScenarioTemplate(ScenarioSource(find_scenario(name), settings))


def load_scenario(name: str | Path, settings: str | Sequence[str] = ()) -> Scenario:
    """The draw of ``load_template`` for the scenario's own seed."""
    return load_template(name, settings).draw()


def dump_scenario(scenario: Scenario) -> str:
    """YAML that loads to the same scenario."""
    return yaml.safe_dump(scenario.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
