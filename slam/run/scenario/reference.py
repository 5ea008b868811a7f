"""The reference of scenario files, as Markdown: every section and key, made from the JSON schema."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, Final

from slam.run.scenario.json_schema import RANDOM, scenario_schema

_PREFIX: Final = "#/$defs/"
_BOUNDS: Final = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
_CHOOSERS: Final = ("method", "kind")
"""The keys that choose among sections."""
Schema = dict[str, Any]


def scenario_reference() -> str:
    """A table for each section, with the type, the default and the meaning of its keys."""
    schema = scenario_schema()
    return "\n".join(["# Scenario reference", "", _INTRODUCTION, *_sections(schema)])


_INTRODUCTION: Final = """Every key of a scenario file, with its default; a key without one must be given. Lengths are in
metres, angles in radians, times in seconds, unless the meaning says otherwise. In place of any value a
[random one](#random-values) may stand. This page is made from the schema that checks the files."""


def _sections(schema: Schema) -> Iterator[str]:
    """The tables of the top, then those of the sections that its keys hold, each once, in the order of the keys."""
    waiting: list[tuple[str, Schema]] = [("top", schema)]
    done: set[str] = set()
    while waiting:
        place, section = waiting.pop(0)
        yield from _table(place, section)
        for name, key in [(name, key) for key, value in section["properties"].items() for name in _held(value)]:
            if name not in done:
                done.add(name)
                inner = schema["$defs"][name]
                waiting.append((_place(place, key, inner), inner | {"name": name}))
    yield "## Random values\n"
    for kind in _held(schema["$defs"][RANDOM]):
        yield from _rows(schema["$defs"][kind])


def _place(outer: str, key: str, section: Schema) -> str:
    """Where a section stands in the file: ``slam.lines, method: paper``."""
    whole = key if outer == "top" else f"{outer.split(',')[0]}.{key}"
    chosen = [f"{c}: {value}" for c in _CHOOSERS if (value := section["properties"].get(c, {}).get("default"))]
    return ", ".join([whole, *chosen])


def _table(place: str, section: Schema) -> Iterator[str]:
    anchor = section.get("name", "top").lower()
    yield f"\n## `{place}` {{#{anchor}}}\n" if place != "top" else "\n## The file {#top}\n"
    yield section["description"] + "\n"
    yield from _rows(section)


def _rows(section: Schema) -> Iterator[str]:
    yield "| key | type | default | meaning |\n|---|---|---|---|"
    for key, value in section["properties"].items():
        cells = f"`{key}`", type_text(value), _default(value), value["description"].replace("``", "`")
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    yield ""


def _default(value: Schema) -> str:
    if "default" not in value:
        return ""
    default = value["default"]
    if isinstance(default, dict):
        return "its own"
    return "none" if default in (None, "", []) else f"`{default if isinstance(default, str) else json.dumps(default)}`"


def _held(value: Any) -> list[str]:
    """The names of the sections in a schema, but for random values."""
    if isinstance(value, dict):
        if "$ref" in value:
            return [name] if (name := value["$ref"].removeprefix(_PREFIX)) != RANDOM else []
        return [name for part in value.values() for name in _held(part)]
    return [name for part in value for name in _held(part)] if isinstance(value, list) else []


def type_text(value: Schema) -> str:
    """What may stand for a value, in words, as ``number > 0``."""
    if "$ref" in value:
        name = value["$ref"].removeprefix(_PREFIX)
        return f"[{name}](#{name.lower()})"
    if "anyOf" in value:
        parts = [part for part in value["anyOf"] if not part.get("$ref", "").endswith(f"/{RANDOM}")]
        return " or ".join(text for part in parts if (text := type_text(part)) != "null")
    if "const" in value or "enum" in value:
        return " or ".join(f"`{choice}`" for choice in value.get("enum", [value.get("const")]))
    if value.get("type") == "array":
        items = value.get("prefixItems") or [value.get("items") or {}]
        kinds = list(dict.fromkeys(map(type_text, items)))
        return f"list of {len(items) if 'prefixItems' in value else ''} {', '.join(kinds)}".replace("  ", " ")
    bounds = [f"{sign} {value[key]:g}" for key, sign in _BOUNDS.items() if key in value]
    return " ".join([value.get("type", "anything"), ", ".join(bounds)]).strip()
