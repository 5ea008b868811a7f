"""The JSON schema of scenario files, with which editors complete and check them."""

import ast
import json
from inspect import cleandoc, getsource
from itertools import pairwise
from math import isinf
from textwrap import dedent
from typing import Any, Final, TypeGuard

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import DEFAULT_REF_TEMPLATE, GenerateJsonSchema

from slam.scenario.clock import Physics
from slam.scenario.random_value import RandomValue
from slam.scenario.schema import Scenario

NEVER_RANDOM: Final = {"name", "seed", "extends"}
RANDOM: Final = "RandomValue"
"""Name of the section of random values."""
_EXTENDS: Final = {
    "type": "string",
    "description": "The scenario that this file extends: a shipped one by name, or a path relative to this file.",
}


def scenario_schema() -> dict[str, Any]:
    """Make the schema of scenario files: any value may be random, and a file may extend another one.

    Rules between several keys are not in it; ``hopslam`` checks those when it reads the file.
    """
    schema = Scenario.model_json_schema(schema_generator=_Documented)
    random = TypeAdapter(RandomValue).json_schema(schema_generator=_Documented)
    sections: dict[str, Any] = schema.pop("$defs")
    for section in [schema, *sections.values()]:
        keys = section["properties"]
        if "kind" in keys:
            del keys["seed"]["default"]  # in a file it is drawn with the scenario's seed
        section["properties"] = {key: keys[key] if key in NEVER_RANDOM else _or_random(keys[key]) for key in keys}
    sections |= random.pop("$defs")
    sections[RANDOM] = random | {"description": "A value that is drawn anew for every seed."}
    schema["properties"] = {"extends": _EXTENDS} | schema["properties"]
    schema.pop("required")  # the name: by default that of the file
    return {"$schema": GenerateJsonSchema.schema_dialect} | schema | {"$defs": sections}


def schema_text() -> str:
    """Return the text of ``scenarios/scenario.schema.json``."""
    return json.dumps(scenario_schema(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


class _Documented(GenerateJsonSchema):
    """Generator of the schema.

    The docstring of each attribute describes its key; a section of a union may omit its method.
    """

    def model_schema(self, schema: Any) -> dict[str, Any]:
        section = super().model_schema(schema)
        docs = attribute_docs(schema["cls"])
        for key, value in section["properties"].items():
            value.pop("title", None)
            value["description"] = docs[key]
        return section

    def tagged_union_schema(self, schema: Any) -> dict[str, Any]:
        return {"anyOf": super().tagged_union_schema(schema)["oneOf"]}

    def encode_default(self, dft: Any) -> Any:
        encoded = super().encode_default(dft)
        if isinstance(dft, Physics):
            return encoded | {"engine": "bullet"}  # also where PyBullet is not installed
        return ".inf" if isinstance(encoded, float) and isinf(encoded) else encoded


def attribute_docs(section: type[BaseModel]) -> dict[str, str]:
    """Return a description of each key of a section: the docstring of the attribute, or that of its section.

    pydantic would read them too, but at every start of every command.
    """
    values = {key: field.annotation for key, field in section.model_fields.items()}
    docs = {key: _line(value.__doc__ or "") for key, value in values.items() if _is_section(value)}
    for part in reversed(section.mro()):
        if _is_section(part):
            docs |= _own_docs(part)
    return docs


def _is_section(value: Any) -> TypeGuard[type[BaseModel]]:
    return isinstance(value, type) and issubclass(value, BaseModel) and value is not BaseModel


def _own_docs(section: type[BaseModel]) -> dict[str, str]:
    definition = ast.parse(dedent(getsource(section))).body[0]
    assert isinstance(definition, ast.ClassDef)
    return {
        attribute.target.id: _line(text)
        for attribute, doc in pairwise(definition.body)
        if isinstance(attribute, ast.AnnAssign) and isinstance(attribute.target, ast.Name)
        if isinstance(doc, ast.Expr) and isinstance(doc.value, ast.Constant)
        if isinstance(text := doc.value.value, str)
    }


def _line(text: str) -> str:
    return " ".join(cleandoc(text).split())


def _or_random(value: dict[str, Any]) -> dict[str, Any]:
    """Make the schema of a value, or of a random one in its place, also in the items of a list."""
    outside = {key: value[key] for key in ("description", "default") if key in value}
    plain = {key: part for key, part in value.items() if key not in outside}
    if "prefixItems" in plain:
        plain["prefixItems"] = [_or_random(item) for item in plain["prefixItems"]]
    if isinstance(plain.get("items"), dict):
        plain["items"] = _or_random(plain["items"])
    return outside | {"anyOf": [plain, {"$ref": DEFAULT_REF_TEMPLATE.format(model=RANDOM)}]}
