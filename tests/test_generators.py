"""Generated worlds: one world per seed, with free space along the route."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.bench.floor_plans import cast_beams
from slam.errors import ScenarioError
from slam.pose import Pose2D, path_lengths
from slam.scenario.file import dump_scenario, load_scenario
from slam.scenario.generators.campus import CampusGenerator
from slam.scenario.generators.corridor import CorridorGenerator
from slam.scenario.generators.loop import LoopGenerator
from slam.scenario.generators.office import OfficeGenerator
from slam.scenario.solids import clearance, obstacle_footprints, sample_path
from slam.scenario.world_plan import GeneratedWorld

Generator = CampusGenerator | CorridorGenerator | LoopGenerator | OfficeGenerator
SEEDS = st.integers(0, 2**31)
PASSAGES = {
    "width": st.floats(2.6, 4.0),
    "lane": st.floats(1.6, 2.0),
    "recesses": st.integers(0, 8),
    "boxes": st.integers(0, 10),
    "tables": st.integers(0, 3),
    "people": st.integers(0, 4),
    "seed": SEEDS,
}
CORRIDORS = st.builds(CorridorGenerator, length=st.floats(15.0, 40.0), **PASSAGES)
LOOPS = st.builds(LoopGenerator, size=st.tuples(st.floats(8.0, 20.0), st.floats(8.0, 20.0)), **PASSAGES)
OFFICES = st.builds(
    OfficeGenerator,
    rooms=st.integers(1, 5),
    room_depth=st.floats(2.0, 5.0),
    corridor_width=st.floats(1.2, 3.0),
    door_width=st.floats(0.8, 1.2),
    shut=st.floats(0.0, 1.0),
    visits=st.integers(0, 10),
    furniture=st.integers(0, 6),
    people=st.integers(0, 4),
    seed=SEEDS,
)
CAMPUSES = st.builds(
    CampusGenerator,
    size=st.tuples(st.floats(40.0, 60.0), st.floats(30.0, 45.0)),
    skew=st.floats(0.0, 3.0),
    passage_width=st.floats(1.4, 3.2),
    shut=st.floats(0.0, 1.0),
    bays=st.floats(0.0, 1.0),
    furniture=st.floats(0.0, 1.0),
    seed=SEEDS,
)


def way(generated: GeneratedWorld) -> np.ndarray:
    return np.unique(sample_path([(generated.start.x, generated.start.y), *generated.waypoints], step=0.06), axis=0)


@given(generator=CAMPUSES)
@settings(max_examples=8)
def test_the_route_of_a_campus_is_wide_enough(generator: CampusGenerator) -> None:
    generated = generator.build()
    assert clearance(way(generated), obstacle_footprints(generated.world.prisms())).min() > 0.3015


@given(generator=st.one_of(CORRIDORS, LOOPS, OFFICES))
@settings(max_examples=100)
def test_routes_are_wide_enough_with_people_beside_them(generator: Generator) -> None:
    generated = generator.build()
    route, solids = way(generated), obstacle_footprints(generated.world.prisms())
    assert clearance(route, solids).min() > 0.3015  # 6 cm apart, samples miss at most sqrt(0.3^2 + 0.03^2) - 0.3 m
    for person in generated.people:
        path = sample_path([*person.waypoints, person.waypoints[0]] if person.closed else person.waypoints, step=0.2)
        assert clearance(path, solids).min() > 0.16
        assert np.linalg.norm(path[:, np.newaxis] - route, axis=2).min() > 0.55


@given(generator=st.one_of(CAMPUSES, CORRIDORS, LOOPS, OFFICES))
@settings(max_examples=30)
def test_a_seed_gives_one_world_and_another_seed_another(generator: Generator) -> None:
    again, other = (generator.model_copy(update={"seed": generator.seed + k}).build() for k in (0, 1))
    assert again == generator.build()
    things = generator.model_dump()
    if things["kind"] in ("campus", "office") or things["boxes"]:
        assert other.world != again.world


def test_the_world_has_the_given_counts() -> None:
    generated = CorridorGenerator(length=30, recesses=5, boxes=7, tables=3, people=2, lane=1.6).build()
    assert (len(generated.world.boxes), len(generated.world.tables), len(generated.people)) == (7, 3, 2)
    assert sum(len(wall.points) - 2 for wall in generated.world.walls) == 4 * 5
    office = OfficeGenerator(rooms=4, visits=3, shut=0.0).build()
    assert sum(len(wall.doors) for wall in office.world.walls) == 8
    assert sum(abs(y) > 1.5 for _, y in office.waypoints) == 3


def test_a_loop_returns_along_another_route() -> None:
    generated = LoopGenerator(size=(10.0, 6.0)).build()
    assert generated.waypoints[-1] == (generated.start.x, generated.start.y)
    assert len(set(generated.waypoints)) == len(generated.waypoints)


def test_a_campus_route_goes_around_and_over_its_beginning() -> None:
    """The route goes once around the ring of 150 m, repeats at least 10 m of it, crosses the court, and repeats the
    second half of the ring."""
    for seed in range(5):
        generated = CampusGenerator(seed=seed).build()
        home, route = (generated.start.x, generated.start.y), list(generated.waypoints)
        once, again = route[: route.index(home) + 1], route[route.index(home) + 1 :]
        assert path_lengths(np.array([home, *once]))[-1] > 145.0
        assert math.dist(home, again[0]) > 10.0
        assert again[0][1] == 0.0
        assert again[-3:] == [once[-3], once[-2], home]


def test_walls_of_a_campus_have_no_gaps() -> None:
    """Every ray from the robot's path ends at a wall, even if the whole campus consists of bays."""
    generated = CampusGenerator(seed=3, bays=1.0, skew=3.0).build()
    edges = np.concatenate([np.stack([o, np.roll(o, -1, axis=0)], axis=1) for o in generated.world.outlines(0.3)])
    for place in way(generated)[::400]:
        distance, _ = cast_beams(edges, Pose2D(*place.tolist()), np.linspace(-np.pi, np.pi, 90))
        assert np.isfinite(distance).all()


def write(folder: Path, text: str) -> Path:
    path = folder / "made.yaml"
    path.write_text(text)
    return path


def test_hand_written_parts_are_kept(tmp_path: Path) -> None:
    text = (
        "generate: {kind: loop, seed: 4}\n"
        "world: {boxes: [{center: [9, 20], size: [1, 1, 1]}]}\n"
        "people: [{waypoints: [[20, 20]]}]\n"
    )
    scenario = load_scenario(write(tmp_path, text))
    generated = LoopGenerator(seed=4).build()
    assert scenario.generate is None
    assert scenario.world.boxes[1:] == generated.world.boxes
    assert scenario.route.waypoints == generated.waypoints
    assert len(scenario.people) == 1
    assert load_scenario(write(tmp_path, dump_scenario(scenario))) == scenario
    by_hand = load_scenario(write(tmp_path, text + "route: {waypoints: [[1, 0]]}\nrobot: {start: {x: 0.5}}\n"))
    assert by_hand.route.waypoints == ((1.0, 0.0),)
    assert by_hand.robot.start.x == 0.5


@pytest.mark.parametrize(
    ("generate", "complaint"),
    [
        ("{kind: corridor, lenght: 9}", "made.yaml:1: generate.lenght: unknown key; did you mean length?"),
        ("{kind: maze}", "made.yaml:1: generate.kind: no kind 'maze'; known here: corridor, campus, office, loop"),
        ("{length: 9}", "generate: kind is missing; one of corridor, campus, office, loop"),
        ("7", "generate: expected a section of settings (got 7)"),
        ("{kind: corridor, length: 9, boxes: 40}", "46 recesses, boxes and tables; the walls have room for 12"),
        ("{kind: corridor, width: 1.3}", "leave less than 0.2 m on either side for furniture"),
        ("{kind: corridor, width: 1, boxes: 0, tables: 0}", "lane = 1.2 m is wider than the passage"),
        ("{kind: loop, people: 2}", "too narrow to meet people in; at least 1.6 m"),
        ("{kind: loop, size: [14, 3]}", "leaves no block inside"),
        ("{kind: office, room_length: [1, 3]}", "room_length: 1 m is too short"),
        ("{kind: office, room_length: [4, 3]}", "generate.room_length: the lower bound comes first"),
        ("{kind: corridor, length: 1.0e+9}", "generate.length: expected a number of at most 1000"),
        ("{kind: office, room_depth: 1.0e+6}", "generate.room_depth: expected a number of at most 1000"),
        ("{kind: campus, size: [30, 30]}", "size = [30.0, 30.0] m leaves no room for wings; at least 33.0 m by 22.6 m"),
        ("{kind: campus, passage_length: [3, 4]}", "passage_length: 3 m lets the wings meet; at least 7.4 m"),
        ("{kind: campus, room_length: [2, 6]}", "rooms of 1.33 m might be drawn; at least 1.55 m"),
        ("{kind: campus, passage_width: 3.5}", "corridor_width: 3.2 m is too narrow; at least 3.5 m"),
        ("{kind: office, door_angle: [1, 2]}", "must lie within pi / 2 and pi"),
    ],
)
def test_parameters_that_do_not_fit_are_named(generate: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=re.escape(complaint)):
        load_scenario(write(tmp_path, f"generate: {generate}\n"))
