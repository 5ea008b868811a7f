"""Pydantic's errors of a scenario, in the terms of its YAML file."""

from typing import Any, NamedTuple, get_args

from pydantic import BaseModel, Tag, ValidationError
from pydantic_core import ErrorDetails

from slam.config import OwnMethod
from slam.config.section import OWN
from slam.errors import did_you_mean
from slam.modes import mode_with
from slam.scenario.expected_value import bare_annotation, describe_expected, is_fixed_list
from slam.scenario.random_value import KINDS
from slam.scenario.yaml_file import KeyPath


class _Place(NamedTuple):
    """The place in the schema that a path of keys in the file leads to."""

    path: KeyPath
    """The path in the file, without the names of methods that pydantic inserts."""
    section: Any
    """Annotation of the innermost section (or union of sections) along the path."""
    value: Any
    """Annotation of the value at its end."""
    others: dict[str, type[BaseModel]]
    """Possible sections at the place of ``section``, by the name that chooses them."""


def validation_message(errors: ValidationError, section: type[BaseModel]) -> tuple[KeyPath, str]:
    """Describe the first of several errors, an unknown key before all others.

    Returns the path of the key in the file, and the fault. ``section`` is the schema of the whole.
    """
    return error_message(min(errors.errors(), key=lambda error: error["type"] != "extra_forbidden"), section)


def error_message(error: ErrorDetails, section: type[BaseModel]) -> tuple[KeyPath, str]:
    """Describe one error: the path of the key, and the fault."""
    place = _walk(error["loc"], section)
    if error["type"] == "union_tag_invalid":
        return (*place.path, _chooser(place.section)), _reason(error, place)
    if error["type"] == "missing" and isinstance(error["loc"][-1], int):  # a missing item: the list is too short
        place = _walk(error["loc"][:-1], section)
        error = error | {"type": "too_short"}
    return place.path, _reason(error, place)


def _reason(error: ErrorDetails, place: _Place) -> str:
    value = error["input"]
    if error["type"] == "extra_forbidden":
        return _unknown(str(error["loc"][-1]), place)
    if error["type"] == "union_tag_invalid":
        name = error["ctx"]["tag"]
        return f"no {_chooser(place.section)} {name!r}; {did_you_mean(name, _choices(place.section))}"
    if error["type"] == "union_tag_not_found" and isinstance(value, dict):
        return f"{_chooser(place.section)} is missing; one of {', '.join(_choices(place.section))}"
    if error["type"] == "union_tag_not_found":
        error = error | {"type": "model_type"}
    return describe_expected(error, place.value) + (_meant_random(value) if isinstance(value, dict) else "")


def _unknown(key: str, place: _Place) -> str:
    """Explain an unknown key: it belongs to another variant of the section, to user code, or is misspelt."""
    if place.section is OwnMethod:
        return f"unknown key; what your own code takes stands under {'.'.join(map(str, place.path[:-1]))}.options"
    names = [name for name, section in place.others.items() if key in section.model_fields and name != OWN]
    if names:
        return _belongs_elsewhere(names, place)
    return f"unknown key; {did_you_mean(key, place.section.model_fields)}"


def _belongs_elsewhere(names: list[str], place: _Place) -> str:
    """Describe the choice that makes the key valid."""
    *outer, part, _ = map(str, place.path)
    needed = f"{'.'.join([*outer, part])}.{_chooser_of(place.others)}={' or '.join(names)}"
    if (mode := mode_with(part, names[0])) is None:
        return f"only with {needed}"
    return f"{mode} mode only: add --set slam.mode={mode} (it needs {needed})"


def _meant_random(value: dict[str, Any]) -> str:
    """Give a hint if a mapping looks like a random value with a misspelt kind."""
    key = next(iter(value), None)
    hint = did_you_mean(str(key), KINDS, otherwise="") if len(value) == 1 and key not in KINDS else ""
    return f" (got {value!r}; {hint})" if hint else ""


def _walk(key_path: KeyPath, section: Any) -> _Place:
    path: KeyPath = ()
    value, others = section, dict[str, type[BaseModel]]()
    for step in key_path:
        choices = _choices(section)
        if step in choices:
            section, others = choices[str(step)], choices
            continue
        path = (*path, step)
        if isinstance(step, int):
            value = _item(value, step)
        elif step in getattr(section, "model_fields", ()):
            value = bare_annotation(section.model_fields[step].annotation)
            inner = _section_in(section.model_fields[step].annotation)
            section, others = (section, others) if inner is None else (inner, {})
    return _Place(path, section, value, others)


def _item(annotation: Any, index: int) -> Any:
    """Find the annotation of an item of this list."""
    items = get_args(annotation)
    return items[index] if is_fixed_list(annotation) and index < len(items) else items[0] if items else annotation


def _section_in(annotation: Any) -> Any:
    """Return the section or union in an annotation such as ``Route`` or ``tuple[Wall, ...]``; None if absent."""
    if _choices(annotation) or (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return annotation
    return next(filter(None, map(_section_in, get_args(annotation))), None)


def _choices(annotation: Any) -> dict[str, type[BaseModel]]:
    """Find the sections of a union by the name that chooses them, as in LineConfig; none for any other annotation."""
    variants = [get_args(variant) for variant in get_args(annotation)]
    return {v[1].tag: v[0] for v in variants if len(v) == 2 and isinstance(v[1], Tag)}


def _chooser(annotation: Any) -> str:
    """Find the key whose value chooses among the sections of a union."""
    return _chooser_of(_choices(annotation))


def _chooser_of(choices: dict[str, type[BaseModel]]) -> str:
    """Find the key that holds the name of each section."""
    name, section = next(iter(choices.items()))
    return next(key for key, field in section.model_fields.items() if field.default == name)
