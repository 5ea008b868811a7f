"""What pydantic finds wrong with a scenario, in the words of its YAML file."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, Tag, ValidationError
from pydantic_core import ErrorDetails

from slam.run.scenario.random_value import KINDS
from slam.run.scenario.yaml_file import Location


def complaint(errors: ValidationError, section: type[BaseModel]) -> tuple[Location, str]:
    """The path of the key, as the file has it, and what is wrong with it; ``section`` is the schema of the whole."""
    error = min(errors.errors(), key=lambda error: error["type"] != "extra_forbidden")
    location, innermost = _walk(error["loc"], section)
    if error["type"] == "union_tag_invalid":
        location = (*location, _chooser(innermost))
    return location, _reason(error, innermost)


def hint(word: str, known: list[str]) -> str:
    """What was perhaps meant, or all that there is."""
    close = get_close_matches(word, known, n=1)
    return f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"


def _reason(error: ErrorDetails, section: Any) -> str:
    if error["type"] == "extra_forbidden":
        return f"unknown key; {hint(str(error['loc'][-1]), list(section.model_fields))}"
    if error["type"] == "union_tag_invalid":
        return f"no {_chooser(section)} {error['ctx']['tag']!r}; {hint(error['ctx']['tag'], list(_choices(section)))}"
    message, value = error["msg"].removeprefix("Value error, "), error["input"]
    if error["type"] == "union_tag_not_found":
        message = "a section of settings belongs here"
        if isinstance(value, dict):
            message = f"{_chooser(section)} is missing; one of {', '.join(_choices(section))}"
    if isinstance(value, dict):
        return message + _meant_random(value)
    return f"{message} (got {value!r})"


def _meant_random(value: dict[str, Any]) -> str:
    """A hint for a mapping that looks like a random value whose kind is misspelt."""
    close = get_close_matches(str(next(iter(value))), list(KINDS), n=1) if len(value) == 1 else []
    return f" (got {value!r}; did you mean {close[0]}?)" if close and close[0] not in value else ""


def _walk(location: Location, section: Any) -> tuple[Location, Any]:
    """The path as the file has it, without the names of methods that pydantic puts into it, and the annotation of the
    innermost section (or choice of sections) on it."""
    path: Location = ()
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


def _chooser(annotation: Any) -> str:
    """The key whose value chooses among the sections of a union: the one that each has its own name in."""
    name, section = next(iter(_choices(annotation).items()))
    return next(key for key, field in section.model_fields.items() if field.default == name)
