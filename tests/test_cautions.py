"""Questionable values: wrong units are refused; routes through walls give a warning."""

from pathlib import Path

import jsonschema
import pytest

from slam.cli.main import main
from slam.errors import ScenarioError
from slam.scenario.checks import find_warnings
from slam.scenario.file import load_template
from slam.scenario.json_schema import scenario_schema
from slam.scenario.schema import Scenario
from slam.scenario.shipped import shipped_scenarios

ROOM = """world:
  walls:
    - {points: [[-3, -2], [4, -2], [4, 3], [-3, 3]], closed: true}
  boxes:
    - {center: [1.5, 1.5], size: [0.6, 0.4, 0.8]}
route:
  waypoints: [[3, -1], [3, 2]]
"""


def room(**changes: object) -> Scenario:
    world = {"walls": [{"points": [[-3, -2], [4, -2], [4, 3], [-3, 3]], "closed": True}]}
    return Scenario.model_validate({"name": "room", "world": world} | changes)


def keys(scenario: Scenario) -> list[str]:
    return [".".join(map(str, key)) for key, _ in find_warnings(scenario)]


@pytest.mark.parametrize(
    ("setting", "meant"),
    [
        ("robot.start.theta=90", "radians, within -6.2832 and 6.2832; 90 degrees are 1.571 radians"),
        ("robot.start.theta=-45", "-45 degrees are -0.7854 radians"),
        ("world.boxes.0.yaw=30", "30 degrees are 0.5236 radians"),
        ("route.speed=400", "m/s, at most 2.2; 400 mm/s are 0.4 m/s"),
        ("route.turn_speed=45", "45 deg/s are 0.7854 rad/s"),
        ("route.arrival=150", "150 mm are 0.15 m"),
        ("robot.limits.linear=1200", "1200 mm/s are 1.2 m/s"),
        ("robot.limits.angular=300", "300 deg/s are 5.236 rad/s"),
        ("robot.limits.acceleration=300", r"300 mm/s\^2 are 0.3 m/s\^2"),
        ("robot.odometry.left_radius=97.5", "97.5 mm are 0.0975 m"),
        ("robot.odometry.track=330", "330 mm are 0.33 m"),
        ("robot.traction.effective_track=357", "357 mm are 0.357 m"),
        ("lidar.height=300", "300 mm are 0.3 m"),
        ("lidar.mount.x=160", "160 mm are 0.16 m"),
        ("lidar.mount.theta=180", "180 degrees are 3.142 radians"),
        ("world.walls.0.thickness=100", "100 mm are 0.1 m"),
        ("world.walls.0.height=2500", "a number of at most 1000 \\(got 2500\\)|2500 mm are 2.5 m"),
        (
            "world.walls.0.doors=[{at: 1, angle: 90}]",
            "radians, within -3.1416 and 3.1416; 90 degrees are 1.571 radians",
        ),
        ("world.tables=[{center: [0, 0], leg: 50}]", "50 mm are 0.05 m"),
        ("people=[{waypoints: [[0, 0]], speed: 1200}]", "1200 mm/s are 1.2 m/s"),
        ("people=[{waypoints: [[0, 0]], keep: 800}]", "800 mm are 0.8 m"),
    ],
)
def test_a_value_in_a_wrong_unit_is_refused(tmp_path: Path, setting: str, meant: str) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(ROOM)
    with pytest.raises(ScenarioError, match=meant):
        load_template(file, [setting])


@pytest.mark.parametrize(
    "data",
    [
        {"robot": {"start": {"theta": 90}}},
        {"route": {"speed": 400}},
        {"route": {"speed": 0}},
        {"world": {"boxes": [{"center": [0, 0], "size": [1, 1, 1], "yaw": 45}]}},
        {"lidar": {"mount": {"x": 160}}},
        {"robot": {"limits": {"angular": 300}}},
    ],
)
def test_an_editor_marks_a_value_in_a_wrong_unit(data: dict[str, object]) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, scenario_schema())


@pytest.mark.parametrize("theta", [0.0, 3.14159, -3.14159, 6.2831])
def test_any_angle_within_one_turn_is_accepted(theta: float) -> None:
    assert room(robot={"start": {"theta": theta}}).robot.start.theta == theta


def test_a_route_through_a_wall_warns_but_not_through_a_door() -> None:
    assert keys(room(route={"waypoints": [[3, -1], [3, 2]]})) == []
    assert keys(room(route={"waypoints": [[3, -1], [9, -1], [9, 2], [3, 2]]})) == [
        "route.waypoints.1",
        "route.waypoints.3",
    ]
    walls = [{"points": [[2, -3], [2, 3]], "doors": [{"at": 2.5, "width": 1.0}]}]
    through = room(world={"walls": walls}, route={"waypoints": [[4, 0]]})
    beside = room(world={"walls": walls}, route={"waypoints": [[4, 1.0]]})
    assert keys(through) == []
    assert keys(beside) == ["route.waypoints.0"]


def test_a_gap_narrower_than_the_robot_warns() -> None:
    for width, strange in ((0.36, True), (0.42, False)):
        posts = [{"center": [2, side * (width / 2 + 0.2)], "size": [0.1, 0.4, 1]} for side in (-1, 1)]
        assert bool(keys(room(world={"boxes": posts}, route={"waypoints": [[4, 0]]}))) == strange


def test_pushable_furniture_and_sills_block_no_route() -> None:
    box = {"center": [2, 0], "size": [0.4, 0.4, 0.5]}
    ahead = {"waypoints": [[4, 0]]}
    assert keys(room(world={"boxes": [box]}, route=ahead)) == ["route.waypoints.0"]
    assert keys(room(world={"boxes": [box | {"mass": 3.0}]}, route=ahead)) == []
    assert keys(room(world={"boxes": [box | {"size": [0.4, 0.4, 0.025]}]}, route=ahead)) == []


def test_people_who_walk_through_walls_warn() -> None:
    there, back = [[0, 1], [9, 1]], [[0, 1], [2, 1]]
    around = {"waypoints": [[3, 2], [3, 0], [9, 1]], "closed": True}
    thin = [{"points": [[1, -5], [1, 5]], "thickness": 0.01}]
    assert keys(room(people=[{"waypoints": back}, {"waypoints": there}, around])) == [
        "people.1.waypoints",
        "people.2.waypoints",
    ]
    assert keys(room(world={"walls": thin}, people=[{"waypoints": back}])) == ["people.0.waypoints"]
    assert keys(room(people=[{"waypoints": back, "speed": 3.5}])) == ["people.0.speed"]


def test_places_and_sizes_in_millimetres_warn() -> None:
    far = room(route={"waypoints": [[2000, 500]]})
    assert keys(far) == ["route.waypoints.0", "route.waypoints.0"]
    assert "1996 m away from all solids" in next(iter(find_warnings(far)))[1]
    assert keys(room(robot={"start": {"x": 2500.0}})) == ["robot.start"]
    assert keys(room(world={"boxes": [{"center": [0, 25], "size": [60, 40, 80]}]})) == ["world.boxes.0.size"]
    tall = {"boxes": [{"center": [3, 2], "size": [0.6, 0.4, 800]}], "cylinders": [{"center": [3, 0], "radius": 0.2}]}
    assert keys(room(world=tall)) == ["world.boxes.0.size"]
    assert keys(room(world={"cylinders": [{"center": [3, 0], "radius": 0.2, "height": 800}]})) == [
        "world.cylinders.0.height"
    ]


@pytest.mark.parametrize(("factor", "strange"), [(140.0, False), (1000.0, True)])
def test_a_whole_world_in_millimetres_warns(factor: float, strange: bool) -> None:
    points = [(factor * x, factor * y) for x, y in [(-3, -2), (4, -2), (4, 3), (-3, 3)]]
    world = room(world={"walls": [{"points": points, "closed": True}]})
    assert list(find_warnings(world)) == [(("world",), "7000 m by 5000 m; lengths are in metres")] * strange


def test_speeds_beyond_the_limits_warn() -> None:
    slow = {"limits": {"linear": 0.4, "angular": 0.5}}
    assert keys(room(robot=slow, route={"speed": 0.5})) == ["route.speed", "route.turn_speed"]


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_give_no_warning(name: str) -> None:
    template = load_template(name)
    for seed in range(3 if template.random else 1):
        assert template.warnings(template.draw(seed)) == []


@pytest.mark.parametrize("command", ["run", "world"])
def test_a_command_warns_with_file_line_and_key(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM.replace("[3, 2]]", "[9, -1]]"))
    out = ["--set", "duration=0.5", "--out", "out"] if command == "run" else ["--out", "out.png"]
    main_exits(["hopslam", command, "room.yaml", *out], monkeypatch)
    warnings = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert len(warnings) == 1
    assert warnings[0].startswith(
        "hopslam: warning: room.yaml:7: route.waypoints.1: the path from (3, -1) to (9, -1) leads"
    )


def main_exits(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", arguments)
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
