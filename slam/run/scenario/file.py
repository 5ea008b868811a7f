"""Scenario files: found by name or path, checked, and complained of by file, line and key."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import Any, get_args

import yaml
from pydantic import BaseModel, Tag, ValidationError
from pydantic_core import ErrorDetails

from slam.errors import ScenarioError
from slam.run.scenario.schema import Scenario
from slam.run.scenario.settings import apply_settings, parse_setting
from slam.run.scenario.yaml_file import Location, YamlFile

SHIPPED = next(
    (p for p in (Path(__file__).parents[2] / "scenarios", Path(__file__).parents[3] / "scenarios") if p.is_dir()),
    Path("scenarios"),
)
"""The scenarios that come with hopslam: inside the wheel, or beside the packages in a checkout."""


def shipped_scenarios() -> list[str]:
    """Their names."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_scenario(name: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """The scenario in this file, or the shipped one of this name, with ``key=value`` settings on top.

    Raises ScenarioError: one line that names file, line and key, what is wrong, and what was perhaps meant.
    """
    file = YamlFile(find_scenario(name))
    overrides = [parse_setting(text) for text in settings]
    apply_settings(file.data, overrides)
    file.data.setdefault("name", file.path.stem)
    try:
        return Scenario.model_validate(file.data)
    except ValidationError as errors:
        first = min(errors.errors(), key=lambda error: error["type"] != "extra_forbidden")
        raise ScenarioError(_complaint(first, file, [location for location, _ in overrides])) from errors


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


def _complaint(error: ErrorDetails, file: YamlFile, overrides: list[Location]) -> str:
    location, section = _walk(error["loc"])
    if error["type"] == "union_tag_invalid":
        location = (*location, "method")
    by_hand = any(path[: len(location)] == location[: len(path)] for path in overrides)
    place = "--set" if by_hand else file.place(location)
    return f"{place}: {'.'.join(map(str, location)) or 'scenario'}: {_reason(error, section)}"


def _reason(error: ErrorDetails, section: Any) -> str:
    if error["type"] == "extra_forbidden":
        return f"unknown key; {_hint(str(error['loc'][-1]), list(section.model_fields))}"
    if error["type"] == "union_tag_invalid":
        return f"no method {error['ctx']['tag']!r}; {_hint(error['ctx']['tag'], list(_choices(section)))}"
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "union_tag_not_found":
        message = "a section of settings belongs here"
    value = error["input"]
    return message if isinstance(value, dict) else f"{message} (got {value!r})"


def _hint(word: str, known: list[str]) -> str:
    close = get_close_matches(word, known, n=1)
    return f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"


def _walk(location: Location) -> tuple[Location, Any]:
    """The path as the file has it, without the names of methods that pydantic puts into it, and the annotation of the
    innermost section (or choice of sections) on it."""
    path: Location = ()
    section: Any = Scenario
    for step in location:
        choices = _choices(section)
        if step in choices:
            section = choices[str(step)]
            continue
        path = (*path, step)
        if step in getattr(section, "model_fields", ()):
            section = _section_in(section.model_fields[step].annotation) or section
    return path, section


def _section_in(annotation: Any) -> Any:
    """The section in an annotation such as ``Route`` or ``tuple[Wall, ...]``, a choice of sections, or None."""
    if _choices(annotation) or (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return annotation
    return next(filter(None, map(_section_in, get_args(annotation))), None)


def _choices(annotation: Any) -> dict[str, type[BaseModel]]:
    """The sections of a union by the name that chooses them, as in LineConfig; nothing for any other annotation."""
    variants = [get_args(variant) for variant in get_args(annotation)]
    return {v[1].tag: v[0] for v in variants if len(v) == 2 and isinstance(v[1], Tag)}
