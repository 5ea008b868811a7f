"""The solids of a world: the area that they cover, and the area that they leave free."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from slam.scenario.furniture import Box, Cylinder, Table
from slam.scenario.solids import clearance, obstacle_footprints, sample_path
from slam.scenario.wall import Door, Wall
from slam.scenario.world_plan import World

CORNERED = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0))


def free(wall: Wall, *points: tuple[float, float]) -> np.ndarray:
    return clearance(np.array(points, dtype=float), [prism.footprint for prism in wall.prisms()])


def area(footprint: np.ndarray) -> float:
    """Positive when the corners go counter-clockwise."""
    x, y = footprint.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0


@given(radius=st.floats(0.002, 20.0))
def test_a_cylinder_is_round_within_a_millimetre(radius: float) -> None:
    (prism,) = Cylinder(center=(1.0, -2.0), radius=radius).prisms()
    middles = (prism.footprint + np.roll(prism.footprint, 1, axis=0)) / 2.0
    distances = np.linalg.norm(np.concatenate([prism.footprint, middles]) - (1.0, -2.0), axis=1)
    assert (distances <= radius + 1e-9).all()
    assert (distances > radius - 1.001e-3).all()
    assert area(prism.footprint) > 0.0


@given(at=st.floats(0.0, 3.0), width=st.floats(0.3, 1.0), yaw=st.floats(-3.0, 3.0))
def test_a_doorway_is_open_only_at_its_place(at: float, width: float, yaw: float) -> None:
    along = np.array([np.cos(yaw), np.sin(yaw)])
    wall = Wall(points=((0, 0), tuple(4.0 * along)), doors=(Door(at=at, width=width),))
    inside, outside = clearance(
        np.array([(at + width / 2) * along, (at + width + 0.01) * along]), [p.footprint for p in wall.prisms()]
    )
    assert inside == pytest.approx(width / 2, abs=1e-9)
    assert outside == (0.0 if at + width + 0.01 < 4.05 else pytest.approx(at + width + 0.01 - 4.05))


@pytest.mark.parametrize("hinge", ["begin", "end"])
def test_a_closed_door_closes_the_wall(hinge: str) -> None:
    wall = Wall(points=CORNERED, doors=(Door(at=4.5, width=1.0, angle=0.0, hinge=hinge),))
    assert (free(wall, *sample_path(CORNERED, 0.01)) == 0.0).all()


@pytest.mark.parametrize(
    ("hinge", "angle", "tip"),
    [
        ("begin", np.pi / 2, (1.0, 0.95)),
        ("end", np.pi / 2, (1.9, 0.95)),
        ("begin", -np.pi / 2, (1.0, -0.95)),
        ("end", -0.75 * np.pi, (1.9 + 0.9 * np.sqrt(0.5), -0.05 - 0.9 * np.sqrt(0.5))),
    ],
)
def test_an_open_leaf_stands_on_the_side_it_opens_to(hinge: str, angle: float, tip: Any) -> None:
    wall = Wall(points=CORNERED, doors=(Door(at=1.0, angle=angle, hinge=hinge),))
    assert free(wall, tip)[0] < 1e-9
    assert free(wall, (1.45, 0.0))[0] == pytest.approx(0.45, abs=0.021)


def test_wall_pieces_beside_doors_keep_direction_and_height() -> None:
    doors = (Door(at=0.0), Door(at=2.0, angle=2.0), Door(at=4.0, angle=-1.0, hinge="end"))
    prisms = list(Wall(points=CORNERED, height=2.1, doors=doors).prisms())
    assert len(prisms) == 7
    assert all(area(prism.footprint) > 0.0 for prism in prisms)
    assert {(prism.bottom, prism.top) for prism in prisms} == {(0.0, 2.1)}


@pytest.mark.parametrize(
    ("doors", "complaint"),
    [
        ([Door(at=3.5)], "from 3.5 m to 4.4 m fits into no straight part of the wall: 0 to 4, 4 to 7 m"),
        ([Door(at=6.5)], "fits into no straight part"),
        ([Door(at=2.0), Door(at=1.5)], "the doors at 1.5 m and at 2 m of the wall overlap"),
    ],
)
def test_a_door_that_does_not_fit_is_refused(doors: Any, complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        Wall(points=CORNERED, doors=doors)


@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0))
def test_clearance_is_the_distance_to_the_nearest_solid(x: float, y: float) -> None:
    boxes = World(boxes=(Box(center=(0, 0), size=(2, 1, 1)), Box(center=(2, 2), size=(1, 1, 1)))).prisms()
    expected = min(
        np.hypot(max(abs(x) - 1.0, 0), max(abs(y) - 0.5, 0)), np.hypot(*np.maximum(np.abs([x - 2, y - 2]) - 0.5, 0))
    )
    assert clearance(np.array([[x, y]]), obstacle_footprints(boxes))[0] == pytest.approx(expected, abs=1e-9)


def test_table_legs_are_obstacles_but_not_the_top() -> None:
    world = World(tables=(Table(center=(0, 0), size=(2, 2, 0.75)),))
    middle, leg = clearance(np.array([[0.0, 0.0], [0.99, 0.99]]), obstacle_footprints(world.prisms()))
    assert middle > 1.0
    assert leg == 0.0
    assert len(world.outlines(0.3)) == 4
    assert len(world.outlines(0.74)) == 1
