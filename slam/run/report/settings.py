"""What was configured: what differs from the defaults first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from slam.config import SlamConfig
from slam.scenario.schema import Scenario

_LONGEST: Final = 60
"""Characters of a value; a longer list is counted."""


@dataclass(frozen=True, slots=True)
class Change:
    """One setting that was not left at its default."""

    key: str
    default: str
    value: str


def changes(scenario: Scenario) -> list[Change]:
    """The settings that differ from the defaults of the scenario's mode, in the order of the schema."""
    defaults = Scenario.model_validate({"name": scenario.name, "slam": {"mode": scenario.slam.mode}})
    given = SlamConfig().mode, scenario.slam.mode
    mode = [] if given[0] == given[1] else [Change("slam.mode", *given)]
    return mode + list(_differences(defaults.model_dump(mode="json"), scenario.model_dump(mode="json"), ""))


def _differences(default: Any, value: Any, key: str) -> Iterator[Change]:
    if isinstance(default, dict) and isinstance(value, dict):
        for name, inner in value.items():
            yield from _differences(default.get(name), inner, f"{key}.{name}" if key else name)
    elif default != value and key != "description":
        yield Change(key, _text(default), _text(value))


def _text(value: Any) -> str:
    text = "none" if value is None or value == [] else str(value)
    if len(text) <= _LONGEST:
        return text
    return f"{len(value)} entries" if isinstance(value, list | dict) else f"{text[:_LONGEST]} …"
