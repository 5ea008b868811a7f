"""The reference of scenario files, as Markdown: every section and key, made from the JSON schema."""

import json
from collections.abc import Iterator
from typing import Any, Final

from slam.config.section import OWN
from slam.scenario.json_schema import RANDOM, scenario_schema

_INTRODUCTION: Final = """# Scenario reference

Every key of a scenario file, with its type and default. A section has its defaults in a table of its own. In place of
any value a [random one](#random) may stand. Sections, figures, equations and procedures with a number are those of the
[paper](https://doi.org/10.5772/63540), whose main equations are in docs/method.md. This page is made from the schema
that checks the files: `hopslam schema` prints it for editors.
"""
_HEAD: Final = "| key | type | default | meaning |\n|---|---|---|---|"
_BOUNDS: Final = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
_CHOOSERS: Final = ("method", "kind")
"""Keys that choose among sections."""
Schema = dict[str, Any]


def scenario_reference() -> str:
    """Write a table for each section, with the type, the default and the meaning of its keys."""
    schema = scenario_schema()
    kinds = [schema["$defs"][name] for name in _held(schema["$defs"][RANDOM])]
    parts = [_INTRODUCTION, "## The file\n", schema["description"], ""]
    parts += [*_rows(schema), *_sections("", schema, dict(schema["$defs"]))]
    text = "\n".join([*parts, "## Random values {#random}\n", *_rows(*kinds)])
    return _choices_named(_notes_once(text, schema["$defs"]), schema["$defs"])


def _notes_once(text: str, sections: Schema) -> str:
    """In the row of a section, keep the first paragraph of its description; the others are under its heading."""
    for section in sections.values():
        first, _, rest = _code(section["description"]).partition("\n\n")
        row, short = (" ".join(part.split()) + " |" for part in (f"{first} {rest}", first))
        text = text.replace(row, short)
    return text


def _choices_named(text: str, sections: Schema) -> str:
    """In links to a section that a key chooses, replace the word section by the choice, as in ``kind: office``."""
    for name, section in sections.items():
        if choice := _choice(section):
            text = text.replace(f"[section](#{name.lower()})", f"[{choice}](#{name.lower()})")
    return text


def _sections(place: str, outer: Schema, left: Schema) -> Iterator[str]:
    """Yield the tables of all sections inside ``outer``, at any depth, each once.

    ``place`` is the path of ``outer``, as in ``slam.``. A section that has its table is removed from ``left``.
    """
    for key, value in outer["properties"].items():
        for name in _held(value):
            if name in left:
                section, path = left.pop(name), f"{place}{key}"
                yield f"## {_title(path, section)} {{#{name.lower()}}}\n"
                yield f"{_code(section['description'])}\n"
                yield from _rows(section)
                yield from _sections(f"{path}.", section, left)


def _title(path: str, section: Schema) -> str:
    """Title of a section, as in ``slam.lines, method: paper``."""
    choice = _choice(section)
    return f"`{path}`, {choice}" if choice else f"`{path}`"


def _choice(section: Schema) -> str:
    """Return the value of the key that chooses this section, as in ``kind: office``; empty if there is no such key."""
    keys = section.get("properties", {})
    return "".join(f"`{key}: {keys[key].get('default', OWN)}`" for key in _CHOOSERS if key in keys)


def _rows(*sections: Schema) -> Iterator[str]:
    """Yield the lines of one table with the keys of these sections."""
    yield _HEAD
    for section in sections:
        for key, value in section["properties"].items():
            default = "required" if key in section.get("required", ()) else _default(value)
            cells = f"`{key}`", type_text(value), default, _code(value["description"])
            yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    yield ""


def _code(docstring: str) -> str:
    return docstring.replace("``", "`")


def _default(value: Schema) -> str:
    default = value.get("default", {})
    if isinstance(default, dict):  # a section's defaults are in its own table
        return ""
    return "none" if default in (None, "", []) else f"`{default if isinstance(default, str) else json.dumps(default)}`"


def _held(value: Any) -> list[str]:
    """List the names of the sections in a schema, except random values."""
    if isinstance(value, dict):
        own = [_name(value)] if "$ref" in value else []
        return [name for name in own if name != RANDOM] + _held(list(value.values()))
    return [name for part in value for name in _held(part)] if isinstance(value, list) else []


def _name(reference: Schema) -> str:
    return str(reference["$ref"]).rpartition("/")[2]


def type_text(value: Schema) -> str:
    """Describe the type of a value in words, as in ``number > 0``."""
    if "$ref" in value:
        return f"[section](#{_name(value).lower()})"
    if "anyOf" in value:
        parts = [part for part in value["anyOf"] if "$ref" not in part or _name(part) != RANDOM]
        return " or ".join(dict.fromkeys(text for part in parts if (text := type_text(part)) != "null"))
    if "const" in value or "enum" in value:
        return " or ".join(f"`{choice}`" for choice in value.get("enum", [value.get("const")]))
    if "prefixItems" in value:
        return f"[{', '.join(map(type_text, value['prefixItems']))}]"
    if value.get("type") == "array":
        return f"list of {type_text(value['items'])}"
    bounds = [f"{sign} {value[key]:g}" for key, sign in _BOUNDS.items() if abs(value.get(key, 1e9)) < 1e9]
    return " ".join([value.get("type", "any value"), " and ".join(bounds)]).strip()
