"""Walking people: their routes, pauses and legs."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.gait import legs_at
from sim.people import People
from slam.scenario.world_plan import Person

FAR = (100.0, 100.0)


def way(*nodes: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    points = np.array(nodes)
    return points, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


SQUARE = way((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0), (0.0, 0.0))


@given(st.floats(0.0, 200.0), st.floats(0.3, 1.0))
def test_one_leg_stands_while_the_other_swings(walked: Any, stride: float) -> None:
    before, after = (legs_at(*SQUARE, at, 0.2, stride) for at in (walked, walked + 1e-3))
    moved = np.linalg.norm(after - before, axis=1)
    if int(walked / stride) == int((walked + 1e-3) / stride):
        assert moved.min() == 0.0
    assert moved.max() < 1e-3 * (
        3.1 + 0.5 / stride
    )  # at most 1.5 times its mean speed, which is twice that of the person


@given(st.floats(0.0, 2.0))
def test_legs_keep_their_sides_on_a_straight_path(walked: Any) -> None:
    nodes, distances = way((0.0, 0.0), (50.0, 0.0), (0.0, 0.0))
    legs = legs_at(nodes, distances, 10.0 + walked, 0.2, 0.7)
    assert legs[:, 1] == pytest.approx([0.1, -0.1])
    assert abs(legs[:, 0].mean() - 10.0 - walked) < 0.36
    assert abs(legs[0, 0] - legs[1, 0]) <= 0.7 + 1e-9


def walked_by(person: Person, seconds: float, robot: tuple[float, float] = FAR) -> np.ndarray:
    from sim.world import World  # late: PyBullet

    with World([], 240) as world:
        people = People(world, [person])
        for _ in range(round(seconds * 60)):
            people.step(robot, 1.0 / 60)
        return people.positions[0]


def test_people_walk_back_and_forth_or_around() -> None:
    points = ((0.0, 0.0), (3.0, 0.0), (3.0, 2.0))
    assert walked_by(Person(waypoints=points), 6.0) == pytest.approx([3.0, 1.0])
    assert walked_by(Person(waypoints=points, closed=True, start=1.0), 4.0 + np.hypot(3, 2)) == pytest.approx(
        [0, 0], abs=0.02
    )
    assert walked_by(Person(waypoints=points, speed=0.5, start=2.0), 4.0) == pytest.approx([3.0, 1.0])


def test_people_rest_at_waypoints() -> None:
    person = Person(waypoints=((0.0, 0.0), (1.0, 0.0)), pause=2.0)
    assert walked_by(person, 2.5) == pytest.approx([1.0, 0.0])
    assert walked_by(person, 3.5)[0] == pytest.approx(0.5, abs=0.04)


@pytest.mark.parametrize("length", [0.5, 1.0, 2.5, 3.0])
def test_a_step_ending_at_a_waypoint_rests_there(length: float) -> None:
    person = Person(waypoints=((0.0, 0.0), (length, 0.0)), pause=2.0)
    assert walked_by(person, length + 1.9)[0] == pytest.approx(length)


def test_people_wait_while_the_robot_is_near_ahead() -> None:
    person = Person(waypoints=((0.0, 0.0), (5.0, 0.0)), keep=0.5)
    assert walked_by(person, 4.0, robot=(2.0, 0.0))[0] == pytest.approx(1.5, abs=0.02)
    assert walked_by(person, 4.0, robot=(-0.2, 0.0))[0] == pytest.approx(4.0)


def test_a_person_with_one_waypoint_stands_there() -> None:
    person = Person(waypoints=((1.0, 2.0), (1.0, 2.0)))
    assert walked_by(person, 3.0) == pytest.approx([1.0, 2.0])
