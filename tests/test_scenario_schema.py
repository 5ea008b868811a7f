"""The JSON schema of scenarios, and the reference made from it."""

import json
import re
from typing import Any, get_args

import jsonschema
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from slam.lidars import LIDARS, LidarName
from slam.modes import MODES, ModeName
from slam.scenario.json_schema import scenario_schema, schema_text
from slam.scenario.reference import scenario_reference
from slam.scenario.schema import Scenario
from slam.scenario.shipped import SHIPPED, shipped_scenarios

SCHEMA = scenario_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
SECTIONS = [SCHEMA, *SCHEMA["$defs"].values()]
LEAVES = {
    "duration": ("duration",),
    "start": ("robot", "start", "x"),
    "slip": ("robot", "traction", "slip"),
    "floor": ("slam", "matching", "floor"),
    "points": ("slam", "lines", "min_points"),
}


def nested(path: tuple[str, ...], value: Any) -> Any:
    return {path[0]: nested(path[1:], value)} if path else value


def accepted(data: dict[str, Any]) -> bool:
    try:
        Scenario.model_validate({"name": "any"} | data)
    except ValidationError:
        return False
    return True


@given(st.sampled_from(sorted(LEAVES)), st.one_of(st.floats(-10, 10), st.integers(-10, 10), st.text(max_size=3)))
def test_the_schema_accepts_what_the_code_accepts(key: str, value: Any) -> None:
    """The reverse does not hold: only the code checks rules between keys and reads numbers given as text."""
    data = nested(LEAVES[key], value)
    assert VALIDATOR.is_valid(data) or not accepted(data) or isinstance(value, str)


@given(st.sampled_from(sorted(LEAVES)), st.text("abcdefgh", min_size=1))
def test_an_unknown_key_is_refused_at_every_depth(key: str, word: str) -> None:
    *path, last = LEAVES[key]
    assert not VALIDATOR.is_valid(nested((*path, f"{last}{word}"), 1.0))


@pytest.mark.parametrize("value", [{"uniform": [1, 2]}, {"choice": [1, 2]}, {"normal": [0, 1]}, {"integer": [0, 1]}])
def test_any_value_may_be_random(value: Any) -> None:
    assert all(VALIDATOR.is_valid(nested(path, value)) for path in LEAVES.values())
    assert VALIDATOR.is_valid({"route": {"waypoints": [[value, 0]]}})
    assert not VALIDATOR.is_valid({"seed": value})


@pytest.mark.parametrize("name", shipped_scenarios())
def test_editors_find_the_schema_of_the_shipped_scenarios(name: str) -> None:
    text = (SHIPPED / f"{name}.yaml").read_text()
    assert text.startswith("# yaml-language-server: $schema=scenario.schema.json\n")
    VALIDATOR.validate(yaml.safe_load(text))


def test_the_shipped_schema_is_that_of_this_code() -> None:
    assert (SHIPPED / "scenario.schema.json").read_text() == schema_text(), "run make schema"


def test_the_schema_is_a_valid_json_schema() -> None:
    VALIDATOR.check_schema(json.loads(schema_text()))


def test_every_key_has_a_description() -> None:
    keys = [item for section in SECTIONS for item in section.get("properties", {}).items()]
    assert len(keys) > 150
    assert [key for key, value in keys if not value.get("description")] == []


def test_the_reference_lists_every_key_with_valid_links() -> None:
    page = scenario_reference()
    anchors = set(re.findall(r"\{#([\w-]+)\}", page))
    assert set(re.findall(r"\]\(#([\w-]+)\)", page)) <= anchors
    keys = {key for section in SECTIONS for key in section.get("properties", {})}
    assert keys <= set(re.findall(r"^\| `(\w+)`", page, re.MULTILINE))


def test_the_reference_has_each_paragraph_of_a_section_once() -> None:
    page = " ".join(scenario_reference().split())
    for section in SCHEMA["$defs"].values():
        for paragraph in section["description"].replace("``", "`").split("\n\n")[1:]:
            assert page.count(" ".join(paragraph.split())) == 1


def test_every_lidar_and_mode_is_in_its_table() -> None:
    assert get_args(LidarName) == tuple(LIDARS)
    assert get_args(ModeName) == tuple(MODES)
