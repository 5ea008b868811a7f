"""``--set key=value``: settings given by hand, on top of a file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml

from slam.errors import ScenarioError
from slam.run.scenario.yaml_file import Location


def parse_setting(text: str) -> tuple[Location, Any]:
    """``slam.lines.psi=2`` as its path and its value, which is read as YAML; a number in the path is an index."""
    key, equals, value = text.partition("=")
    if not equals or not all(key.strip().split(".")):
        raise ScenarioError(f"--set {text}: expected key=value, for example --set slam.lines.psi=2")
    try:
        parsed = yaml.safe_load(value)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ScenarioError(f"--set {text}: the value is not valid YAML; quote it if it is text") from error
    return tuple(int(step) if step.isascii() and step.isdigit() else step for step in key.strip().split(".")), parsed


def apply_settings(data: dict[str, Any], settings: Iterable[tuple[Location, Any]]) -> None:
    """Write each setting into the nested ``data``, making the mappings that are missing on the way."""
    for location, value in settings:
        at: Any = data
        for step in location[:-1]:
            at = _enter(at, step, location)
        _check_item(at, location[-1], location)
        at[location[-1]] = value


def _enter(at: Any, step: str | int, location: Location) -> Any:
    if isinstance(at, dict):
        if at.get(step) is None:
            at[step] = {}
        return at[step]
    _check_item(at, step, location)
    return at[step]


def _check_item(at: Any, step: str | int, location: Location) -> None:
    """Refuse a path that leads through a plain value, or to an item that its list has not."""
    name = ".".join(map(str, location))
    if isinstance(at, list):
        if not isinstance(step, int) or step >= len(at):
            raise ScenarioError(f"--set {name}: there are {len(at)} items here; {step} is none of 0 to {len(at) - 1}")
    elif not isinstance(at, dict):
        raise ScenarioError(f"--set {name}: {step} lies inside {at!r}, which has no parts")
