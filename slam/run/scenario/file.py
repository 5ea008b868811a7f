"""Scenario files: found by name or path, loaded, and written."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path

import yaml

from slam.errors import ScenarioError
from slam.run.scenario.schema import Scenario
from slam.run.scenario.source import ScenarioSource
from slam.run.scenario.template import ScenarioTemplate

SHIPPED = next(
    (p for p in (Path(__file__).parents[2] / "scenarios", Path(__file__).parents[3] / "scenarios") if p.is_dir()),
    Path("scenarios"),
)
"""The scenarios that come with hopslam: inside the wheel, or beside the packages in a checkout."""


def shipped_scenarios() -> list[str]:
    """Their names."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_template(name: str | Path, settings: Sequence[str] = ()) -> ScenarioTemplate:
    """The scenario in this file, or the shipped one of this name, with ``key=value`` settings on top, to draw from.

    Raises ScenarioError: one line that names file, line and key, what is wrong, and what was perhaps meant.
    """
    return ScenarioTemplate(ScenarioSource(find_scenario(name), settings))


def load_scenario(name: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """The draw of ``load_template`` for the scenario's own seed."""
    return load_template(name, settings).draw()


def find_scenario(name: str | Path) -> Path:
    """The path of a scenario given by path or by name."""
    path, shipped = Path(name), SHIPPED / f"{name}.yaml"
    with suppress(OSError):  # a name too long for a file
        if path.is_file():
            return path
        if shipped.is_file():
            return shipped
    known = shipped_scenarios()
    close = get_close_matches(str(name), known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"give a path, or one of: {', '.join(known)}"
    raise ScenarioError(f"no scenario {str(name)!r}: no such file, and none of that name is shipped; {hint}")


def dump_scenario(scenario: Scenario) -> str:
    """YAML that loads to the same scenario."""
    return yaml.safe_dump(scenario.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
