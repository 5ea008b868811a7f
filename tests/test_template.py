"""Scenarios with random values."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel

from slam.errors import ScenarioError
from slam.scenario.file import dump_scenario, load_scenario, load_template
from slam.scenario.random_value import KINDS
from slam.scenario.schema import Scenario

TEXT = """\
world:
  boxes:
    - {center: [{uniform: [3, 4]}, 0], size: [1, 1, 1]}
robot:
  odometry:
    travel_noise: {uniform: [0.001, 0.005]}
    track: {normal: [0.33, 0.002]}
lidar:
  model: {choice: [table1, urg04lx]}
slam:
  matching: {max_iterations: {integer: [100, 300]}}
seed: 5
"""


def write(folder: Path, text: str = TEXT) -> Path:
    path = folder / "random.yaml"
    path.write_text(text)
    return path


def test_a_draw_is_the_same_for_a_seed_and_within_its_bounds(tmp_path: Path) -> None:
    template, again = load_template(write(tmp_path)), load_template(write(tmp_path))
    draws = [template.draw(seed) for seed in range(200)]
    assert [again.draw(seed) for seed in reversed(range(200))] == draws[::-1]
    assert [scenario.seed for scenario in draws] == list(range(200))
    noise = np.array([scenario.robot.odometry.travel_noise for scenario in draws])
    assert 0.001 <= noise.min() < 0.0012
    assert 0.0048 < noise.max() <= 0.005
    tracks = np.array([scenario.robot.odometry.track for scenario in draws])
    assert np.abs(tracks - 0.33).max() <= 0.006
    assert tracks.std() == pytest.approx(0.002, rel=0.15)
    assert {scenario.lidar.model for scenario in draws} == {"table1", "urg04lx"}
    iterations = [scenario.slam.matching.max_iterations for scenario in draws]
    assert min(iterations) >= 100
    assert max(iterations) <= 300
    assert len(set(iterations)) > 80


def test_another_process_draws_the_same(tmp_path: Path) -> None:
    program = (
        "import sys; from slam.scenario.file import *; "
        "print(dump_scenario(load_template(sys.argv[1]).draw(77)), end='')"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, write(tmp_path)],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[1],
    )
    assert done.stdout == dump_scenario(load_template(write(tmp_path)).draw(77))


def test_the_own_seed_is_drawn_and_dumped_as_values(tmp_path: Path) -> None:
    template = load_template(write(tmp_path))
    scenario = load_scenario(write(tmp_path))
    assert template.random
    assert scenario == template.draw() == template.draw(5)
    assert load_scenario(tmp_path / "random.yaml", ["seed=6"]) == template.draw(6)
    dumped = load_template(write(tmp_path, dump_scenario(scenario)))
    assert not dumped.random
    assert dumped.draw() == scenario


def test_another_random_key_leaves_the_others_as_they_are(tmp_path: Path) -> None:
    before = load_template(write(tmp_path)).draw(9)
    after = load_template(write(tmp_path), ["route.speed={uniform: [0.2, 0.6]}"]).draw(9)
    assert after.route.speed != before.route.speed
    assert after.model_copy(update={"route": before.route}) == before


def test_equal_ranges_of_different_keys_draw_differently(tmp_path: Path) -> None:
    wheels = "robot: {odometry: {left_radius: {uniform: [0.09, 0.1]}, right_radius: {uniform: [0.09, 0.1]}}}"
    odometry = [load_template(write(tmp_path, wheels)).draw(seed).robot.odometry for seed in range(100)]
    left, right = np.array([(o.left_radius, o.right_radius) for o in odometry]).T
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.3


def test_without_random_values_draws_differ_by_their_seed_only() -> None:
    template = load_template("corridor")
    assert not template.random
    assert template.draw(3) == load_scenario("corridor").model_copy(update={"seed": 3})


def test_a_generator_without_a_seed_is_random(tmp_path: Path) -> None:
    template = load_template(write(tmp_path, "generate: {kind: loop}"))
    assert template.random
    assert template.draw(1).world != template.draw(2).world
    assert template.draw(1) == load_template(tmp_path / "random.yaml").draw(1)
    assert not load_template(write(tmp_path, "generate: {kind: loop, seed: 3}")).random


def test_the_kind_of_generator_and_the_method_may_be_random(tmp_path: Path) -> None:
    text = (
        "generate: {kind: {choice: [corridor, loop, office]}}\nslam: {lines: {method: {choice: [paper, chi_square]}}}"
    )
    draws = [load_template(write(tmp_path, text)).draw(seed) for seed in range(12)]
    assert len({len(scenario.route.waypoints) for scenario in draws}) >= 3
    assert {scenario.slam.lines.method for scenario in draws} == {"paper", "chi_square"}


def test_no_key_of_a_scenario_is_named_like_a_distribution() -> None:
    seen: set[Any] = set()

    def keys(annotation: Any) -> set[str]:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            if annotation in seen:
                return set()
            seen.add(annotation)
            fields = annotation.model_fields
            return set(fields).union(*(keys(field.annotation) for field in fields.values()))
        return set().union(*map(keys, get_args(annotation)))

    names = keys(Scenario)
    assert {"psi", "corridor_width", "stride"} <= names
    assert not names & set(KINDS)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "[0.001, 0.005]",
            "[0.005, 0.001]",
            "random.yaml:6: robot.odometry.travel_noise: uniform: the lower bound comes",
        ),
        (
            "[0.001, 0.005]",
            "[0.001]",
            "random.yaml:6: robot.odometry.travel_noise: uniform: expected a list of 2 numbers",
        ),
        ("[0.001, 0.005]", "[0, .inf]", "travel_noise: uniform: expected a finite number (got inf)"),
        (
            "[0.001, 0.005]",
            "[-0.001, 0.005]",
            "6: robot.odometry.travel_noise: expected a number of at least 0",
        ),
        (
            "[0.33, 0.002]",
            "[0.33, 0.2]",
            "random.yaml:7: robot.odometry.track: expected a number greater than 0 (got -0.27",
        ),
        ("[0.33, 0.002]", "[0.33, -1]", "random.yaml:7: robot.odometry.track: normal: expected a number of at least 0"),
        ("[table1, urg04lx]", "[table1, urg5]", "random.yaml:9: lidar.model: expected 'table1'"),
        ("[table1, urg04lx]", "[]", "random.yaml:9: lidar.model: choice: expected a list of 1 or more values (got [])"),
        (
            "[100, 300]",
            "[0, 300]",
            "random.yaml:11: slam.matching.max_iterations: expected a number of at least",
        ),
        (
            "[100, 300]",
            f"[0, {10**30}]",
            "max_iterations: integer: expected a number of at most 46116860184273",
        ),
        ("{integer: [100, 300]}", "{uniform: [100, 300.5]}", "max_iterations: expected a whole number"),
        (
            "integer:",
            "intger:",
            "max_iterations: expected a whole number (got {'intger': [100, 300]}; did you mean",
        ),
        ("seed: 5", "seed: {integer: [1, 5]}", "random.yaml:12: seed: cannot be random"),
        ("uniform: [3, 4]", "uniform: [0, 0.1]", "random.yaml:4: robot.start: (0, 0) is inside a solid"),
    ],
)
def test_a_bad_range_is_refused_when_the_file_is_loaded(old: str, new: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=re.escape(complaint)) as error:
        load_template(write(tmp_path, TEXT.replace(old, new, 1)))
    assert "\n" not in str(error.value)


def test_a_bad_range_of_an_option_names_the_option(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=re.escape("--set: route.speed: expected a number greater than 0")):
        load_template(write(tmp_path), ["route.speed={uniform: [0, 1]}"])


def test_a_start_in_a_solid_is_drawn_again(tmp_path: Path) -> None:
    template = load_template(write(tmp_path), ["robot.start.x={uniform: [0, 7]}"])
    for seed in range(60):
        scenario = template.draw(seed)
        assert abs(scenario.robot.start.x - scenario.world.boxes[0].center[0]) >= 0.75


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        (["robot.start.x=-1.5"], "--set: robot.start: (-1.5, 0) is inside a solid; the robot needs 0.25 m"),
        (["robot.start.y=1.8"], "--set: robot.start: (0, 1.8) is 0.15 m from a solid"),
        (["route.waypoints.1=[7.9, -1.6]"], "--set: route.waypoints.1: (7.9, -1.6) is inside a solid"),
        (["world.boxes=[{center: [0, 0], size: [1, 1, 1]}]"], "corridor.yaml:"),
    ],
)
def test_a_robot_inside_a_solid_is_refused(settings: list[str], complaint: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(complaint)):
        load_scenario("corridor", settings)


def test_under_a_table_there_is_room() -> None:
    assert load_scenario("corridor", ["robot.start={x: 2.6, y: -1.55}"]).robot.start.x == 2.6
