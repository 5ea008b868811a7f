"""Scenario files: errors name file, line and key."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.config import ChiSquareConfig, HoppingConfig
from slam.errors import ScenarioError
from slam.modes import MODES
from slam.scenario.file import dump_scenario, load_scenario
from slam.scenario.shipped import shipped_scenarios
from slam.scenario.solids import clearance, obstacle_footprints, sample_path

GOOD = """\
name: small
world:
  boxes:
    - {center: [1, 2], size: [1, 1, 1]}
route:
  speed: 0.3
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "small.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", shipped_scenarios())
def test_a_shipped_scenario_is_dumped_and_loaded_unchanged(name: str, tmp_path: Path) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.description
    assert load_scenario(write(tmp_path, dump_scenario(scenario))) == scenario


def test_the_scenarios_of_the_task_are_shipped() -> None:
    required = {
        "corridor",
        "paper_simulation",
        "paper_corridor",
        "replay",
        "office_loop",
        "cluttered_room",
        "crowded_corridor",
    }
    assert required | {"campus_loop", "featureless_corridor", "random_office"} <= set(shipped_scenarios())


@pytest.mark.parametrize("name", sorted(set(shipped_scenarios()) - {"replay"}))
def test_the_robot_can_drive_the_route_of_a_shipped_scenario(name: str) -> None:
    scenario = load_scenario(name)
    start = scenario.robot.start
    way = sample_path([(start.x, start.y), *scenario.route.waypoints], step=0.03)
    assert clearance(way, obstacle_footprints(scenario.world.prisms())).min() > 0.3


def test_loop_and_bare_corridor_have_their_shapes() -> None:
    loop = load_scenario("office_loop")
    assert loop.route.waypoints[-1] == (loop.robot.start.x, loop.robot.start.y)
    assert len(set(loop.route.waypoints)) == len(loop.route.waypoints)
    bare = load_scenario("featureless_corridor")
    reach = bare.lidar.description.lidar.range_max
    ends = np.concatenate(bare.world.outlines(bare.lidar.height))[:, 0]
    assert ends.min() < bare.robot.start.x - reach
    assert ends.max() > bare.route.waypoints[-1][0] + reach


def test_the_name_comes_from_the_file(tmp_path: Path) -> None:
    assert load_scenario(write(tmp_path, "duration: 3")).name == "small"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("speed:", "speeed:", "small.yaml:6: route.speeed: unknown key; did you mean speed?"),
        ("size:", "sizzle:", "small.yaml:4: world.boxes.0.sizzle: unknown key; did you mean size?"),
        (
            "speed:",
            "colour:",
            "route.colour: unknown key; known here: waypoints, speed, turn_speed, arrival",
        ),
        ("0.3", "-1", "small.yaml:6: route.speed: expected a number greater than 0 (got -1)"),
        ("0.3", "fast", "small.yaml:6: route.speed: expected a number (got 'fast')"),
        (
            "[1, 2]",
            "[1, 2.0e+9]",
            "small.yaml:4: world.boxes.0.center.1: expected a number of at most 5000 (got",
        ),
        ("[1, 2]", "[1]", "small.yaml:4: world.boxes.0.center: expected a list of 2 numbers, like [1, 2] (got [1])"),
        ("  speed: 0.3", "  speed: 0.3\n  speed: 0.4", "small.yaml:7: speed: this key stands here for the second time"),
        ("  speed: 0.3", "  speed: [", "small.yaml:7: not valid YAML: a value is missing, or a bracket is not closed"),
        ("name: small", "- name", "small.yaml:2: not valid YAML"),
    ],
)
def test_a_mistake_names_its_key_and_line(old: str, new: str, complaint: str, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(ScenarioError, match=re.escape(complaint)) as error:
        load_scenario(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("setting", "theirs", "needed"),
    [
        ("slam.lines.psi=1", "paper", "slam.lines.method=paper"),
        ("slam.map.draw=0.5", "paper", "slam.map.method=points"),
        ("slam.matching.kappa=2", "paper", "slam.matching.method=force_field"),
        ("slam.lines.merge_cost=20", "hopslam", "slam.lines.method=chi_square"),
        ("slam.map.cell=0.1", "hopslam", "slam.map.method=surfels"),
        ("slam.matching.motion.along=0.1", "hopslam", "slam.matching.method=least_squares"),
    ],
)
def test_a_setting_of_another_mode_names_that_mode(setting: str, theirs: str, needed: str, mode: str) -> None:
    """If the setting is refused, adding what the message says makes it work."""
    given, says = (
        [f"slam.mode={mode}", setting],
        f"{theirs} mode only: add --set slam.mode={theirs} (it needs {needed})",
    )
    if (mode == "paper") == (theirs == "paper"):
        assert load_scenario("corridor", given).slam.mode == mode
        return
    with pytest.raises(ScenarioError, match=re.escape(says)):
        load_scenario("corridor", given)
    assert load_scenario("corridor", [*given, f"slam.mode={theirs}"]).slam.mode == theirs


def test_the_example_of_the_hint_works_in_every_scenario() -> None:
    with pytest.raises(ScenarioError) as refused:
        load_scenario("corridor", ["nonsense"])
    example = str(refused.value).rpartition("--set ")[2]
    for name in shipped_scenarios():
        load_scenario(name, [example])


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("a:\n\tb: 1\n", 2, "a tab"),
        ("a: @x\n", 1, "'@' must be in quotes"),
        ("a: [1, 2]]\n", 1, "a ] too many"),
        ("a: 1\n- b\n", 2, "a list item among keys"),
        ("a:\n  b: 1\n c: 2\n", 3, "check its indentation"),
        ("a: b: c\n", 1, "text with a ': ' in it must be in quotes"),
        ("a:1\nb: 2\n", 2, "that a space follows the ':' of the line above"),
        ("a: 1\nb\n", 2, "a key without ':'"),
        ("a: - b\n", 1, "a line of its own"),
        ("b: 1\na: {x: 1\n", 2, "not closed by }"),
        ("a: 'it's'\n", 1, "use the other quotes"),
        ("b: 1\na: 'x\nc: 1\n", 2, "a quotation mark is not closed"),
        ('a: "x\\q"\n', 1, "single quotes"),
        ("a: 1\n---\nb: 2\n", 2, "a second document"),
        ("a: *x\n", 1, "marked with &"),
        ("a: !!python/name:os.system\n", 1, "the tag python/name:os.system is not read"),
        ("[1]: 2\n", 1, "a key must be plain text"),
        ("a: 2024-13-45\n", None, "month must be in 1..12; put it in quotes"),
        ("a: !!bool x\n", None, "a value cannot be read"),
    ],
)
def test_invalid_yaml_is_reported_in_plain_words(text: str, line: int | None, says: str, tmp_path: Path) -> None:
    place = "small.yaml" if line is None else f"small.yaml:{line}"
    with pytest.raises(ScenarioError, match=rf"{place}: not valid YAML: .*{re.escape(says)}"):
        load_scenario(write(tmp_path, text))


KEYS = [
    "name", "world.walls", "people", "robot.start", "lidar.model", "route.waypoints", "slam", "slam.mode", "slam.lines",
    "slam.matching.method", "generate", "hardware.robot_port",
]  # fmt: skip
SCALARS = st.none() | st.booleans() | st.integers(-9, 9) | st.text("ab:", max_size=3)
NAMES = st.sampled_from(["x", "method", "choice", "points"])
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=2), max_leaves=6
)


@given(st.sampled_from(KEYS), VALUES)
@settings(max_examples=100)
def test_no_message_uses_words_of_pydantic(key: str, value: object) -> None:
    said = ""
    try:
        load_scenario("corridor", [f"{key}={json.dumps(value)}"])
    except ScenarioError as error:
        said = str(error)
    assert not re.search(r"Input should|valid tuple|dictionary|instance of|pattern|Field required|\n", said)


def test_an_extending_scenario_is_merged_per_mapping(tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    faster = tmp_path / "faster.yaml"
    faster.write_text("extends: small.yaml\nroute: {speed: 0.9}\nworld: {boxes: []}\n")
    scenario = load_scenario(faster)
    assert (scenario.name, scenario.route.speed, scenario.world.boxes) == ("faster", 0.9, ())
    faster.write_text("extends: small.yaml\nroute: {turn_speed: {uniform: [0.1, 0.2]}}\n")
    assert load_scenario(faster).route.speed == 0.3
    assert load_scenario(faster).world == load_scenario(tmp_path / "small.yaml").world


@pytest.mark.parametrize(
    ("below", "above", "complaint"),
    [
        (GOOD, "extends: smal.yaml\n", "above.yaml:1: extends: no scenario 'smal.yaml'"),
        (GOOD, "name: a\nextends: above.yaml\n", "above.yaml:2: extends: above.yaml extends this file; break the ring"),
        ("extends: above.yaml\n", "extends: small.yaml\n", "small.yaml:1: extends: above.yaml extends this file"),
        (
            GOOD.replace("0.3", "-1"),
            "extends: small.yaml\n",
            "small.yaml:6: route.speed: expected a number greater than 0",
        ),
        (
            GOOD,
            "extends: small.yaml\nroute:\n  speed: -1\n",
            "above.yaml:3: route.speed: expected a number greater than 0",
        ),
        (GOOD, "extends: [small]\n", "above.yaml:1: extends: no scenario"),
    ],
)
def test_a_mistake_names_the_extended_file(below: str, above: str, complaint: str, tmp_path: Path) -> None:
    write(tmp_path, below)
    (tmp_path / "above.yaml").write_text(above)
    with pytest.raises(ScenarioError, match=re.escape(complaint)):
        load_scenario(tmp_path / "above.yaml")


@pytest.mark.parametrize(
    "text", ["", "[1, 2]", "just words", "\x00\x01", "a: &a [*a]", "a: " + 5000 * "[" + 5000 * "]", "x: 2018-13-45"]
)
def test_a_file_that_is_not_a_scenario_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"small\.yaml"):
        load_scenario(write(tmp_path, text))


def test_python_objects_in_yaml_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"small\.yaml:1: not valid YAML"):
        load_scenario(write(tmp_path, "name: !!python/object/apply:os.getcwd []"))


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("coridor", "did you mean corridor?"),
        ("zzz", "give a path, or one of: campus_loop, cluttered_room"),
        (300 * "a", "give a path, or one of: campus_loop, cluttered_room"),
    ],
)
def test_a_missing_scenario_suggests_a_name(name: str, hint: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(hint)):
        load_scenario(name)


def test_the_mode_sets_the_methods_left_out(tmp_path: Path) -> None:
    paper = load_scenario(write(tmp_path, GOOD + "slam:\n  mode: paper\n  lines:\n    psi: 0\n"))
    assert paper.slam.lines == HoppingConfig(psi=0)
    own = load_scenario(write(tmp_path, GOOD + "slam:\n  lines:\n    method: chi_square\n    min_points: 9\n"))
    assert own.slam.lines == ChiSquareConfig(min_points=9)
    saved_before_noise_was_learnt = {"min_points": 9, "shared_error": 0.02}
    assert ChiSquareConfig.model_validate(saved_before_noise_was_learnt) == own.slam.lines
    for scenario in (paper, own):
        assert load_scenario(write(tmp_path, dump_scenario(scenario))) == scenario


def test_a_mistake_in_method_settings_has_its_line(tmp_path: Path) -> None:
    text = GOOD + "slam:\n  lines:\n    method: chi_square\n    min_pints: 9\n"
    complaint = f"small.yaml:{text.count(chr(10))}: slam.lines.min_pints: unknown key; did you mean min_points?"
    with pytest.raises(ScenarioError, match=re.escape(complaint)):
        load_scenario(write(tmp_path, text))


def test_settings_change_values_and_items() -> None:
    scenario = load_scenario(
        "paper_corridor", ["slam.lines.psi=0", "route.waypoints.0=[3, 0]", "slam.lines.split_gap=.inf"]
    )
    assert scenario.slam.lines.psi == 0
    assert scenario.route.waypoints[0] == (3.0, 0.0)
    assert scenario.slam.lines.split_gap == float("inf")


@pytest.mark.parametrize(
    ("setting", "complaint"),
    [
        ("slam.lines.psy=1", "--set: slam.lines.psy: unknown key; did you mean psi?"),
        ("slam.lines.psi=9", "--set: slam.lines: psi = 9 over-hops"),
        ("slam.lines.method=papre", "--set: slam.lines.method: no method 'papre'; did you mean paper?"),
        ("slam.lines.method=[1]", "--set: slam.lines.method: no method '[1]'; known here: paper, chi_square"),
        ("slam.lines=5", "--set: slam.lines: expected a section of settings (got 5)"),
        ("slam.lines={method: chi_square, min_point: 9}", "lines.min_point: unknown key; did you mean min_points?"),
        (
            "slam.lines={method: chi_square, merge_cost: 0}",
            "--set: slam.lines.merge_cost: expected a number greater than 0",
        ),
        ("slam.lines.psi", "--set slam.lines.psi: expected key=value, for example --set duration=60"),
        ("=3", "--set =3: expected key=value"),
        ("route.waypoints.7=[0, 0]", "there are 2 items here; 7 is not in 0 to 1"),
        ("route.speed.x=1", "x lies inside 0.5, which has no parts"),
        ("route.speed=[", "the value is not valid YAML"),
        ("duration=.inf", "--set: duration: expected a finite number (got inf)"),
        ("robot.start.x=.nan", "--set: robot.start.x: expected a finite number (got nan)"),
        ("duration=0.05", "duration = 0.05 s ends before the first scan"),
        ("name=../evil", "--set: name: expected letters, digits, spaces"),
        ("world.walls.².x=1", "² is not in 0 to 3"),
        ("seed=" + 5000 * "9", "the value is not valid YAML"),
        ("physics.rate=250.5", "--set: physics.rate: expected a whole number (got 250.5)"),
    ],
)
def test_a_bad_setting_is_named(setting: str, complaint: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(complaint)):
        load_scenario("paper_corridor", [setting])
