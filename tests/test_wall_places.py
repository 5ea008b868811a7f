"""Places from walls alone: laws, rooms with known places, and plain references of compiled functions."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from slam.config import SurfelMapConfig
from slam.graph.constellation import ALONG_X, ALONG_Y, CELL, CELLS, LENGTH, MIDDLE_X, MIDDLE_Y, Constellation
from slam.graph.place_evidence import contradicted, metres_on, normal_equations, weigh_places
from slam.graph.wall_places import propose_places
from slam.graph.wall_votes import (
    BLUR,
    CHANCE,
    REACH,
    SHIFTS_APART,
    XX,
    XY,
    YY,
    fixedness,
    moved,
    places_voted_for,
    shift_votes,
    turn_votes,
)
from slam.mapping.surfel_map import SurfelMap
from slam.matching.coarse_search import HEADING, PLACE_X, SCORE
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan


def outline(*corners: tuple[float, float]) -> FloatArray:
    """The walls (W, 2, 2) between these corners, counter-clockwise about the floor, and back to the first."""
    return np.stack([np.array(corners, float), np.roll(np.array(corners, float), -1, axis=0)], axis=1)


L_ROOM = outline((-3, -2), (4, -2), (4, 1), (1, 1), (1, 4), (-3, 4))
HALL = outline((-4, -2.5), (4, -2.5), (4, 2.5), (-4, 2.5))
CORRIDOR = np.array([[[-9.0, -1.0], [9.0, -1.0]], [[9.0, 1.0], [-9.0, 1.0]]])
POSES = st.builds(Pose2D, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3.1, 3.1))


def constellation(walls: FloatArray, T: Pose2D | None = None) -> Constellation:
    """Walls after they were moved."""
    return Constellation.of((T or Pose2D()).transform(walls))


def offices(seed: int) -> FloatArray:
    """A corridor with doors at odd distances, seen from inside."""
    random = np.random.default_rng(seed)
    walls = []
    for side in (-1.0, 1.0):
        x = -8.0
        while x < 7.0:
            end = x + random.uniform(0.8, 3.0)
            a, b = (x, side), (end, side)
            walls.append((a, b) if side < 0 else (b, a))
            if random.random() < 0.5:  # the far end of a recess
                walls.append(((end, side), (end, 1.5 * side)) if side < 0 else ((end, 1.5 * side), (end, side)))
            x = end + random.uniform(0.8, 1.2)
    return np.array(walls)


def assert_near(place: FloatArray, T: Pose2D, metres: float = 0.05, radians: float = 0.02) -> None:
    off = T.between(Pose2D.from_array(place[PLACE_X:]))
    assert off.distance(Pose2D()) < metres
    assert abs(off.theta) < radians


@settings(max_examples=30, deadline=None)
@given(POSES)
def test_a_room_is_found_where_it_lies(T: Pose2D) -> None:
    found = propose_places(constellation(L_ROOM), constellation(L_ROOM, T))
    assert_near(found[0], T)


@settings(max_examples=30, deadline=None)
@given(POSES, st.integers(0, 5))
def test_a_place_turns_and_shifts_with_either_submap(T: Pose2D, seed: int) -> None:
    walls = offices(seed)
    assert_near(propose_places(constellation(walls, T), constellation(walls))[0], T.inverse())
    assert_near(propose_places(constellation(walls), constellation(walls, T))[0], T)


@settings(max_examples=20, deadline=None)
@given(POSES)
@example(Pose2D(-1.59375, 1.5, -0.296875))  # 6 cm off if refined with a wide kernel only
def test_swapping_the_submaps_gives_the_inverse_place(T: Pose2D) -> None:
    a, b = constellation(offices(0)[:-3]), constellation(offices(0)[3:], T)
    there, back = propose_places(a, b)[0], propose_places(b, a)[0]
    assert_near(back, Pose2D.from_array(there[PLACE_X:]).inverse())


def test_the_order_of_the_walls_changes_no_bit() -> None:
    walls, others = offices(0), Pose2D(1.0, 0.3, 2.0).transform(offices(1))
    plain = propose_places(constellation(walls), constellation(others))
    turned_round = propose_places(constellation(walls[::-1]), constellation(np.roll(others, 5, axis=0)))
    assert plain.tobytes() == turned_round.tobytes()


def test_a_symmetric_hall_has_two_places() -> None:
    found = propose_places(constellation(HALL), constellation(HALL))
    best = sorted(found[:2], key=lambda place: abs(place[HEADING]))
    assert_near(best[0], Pose2D())
    assert_near(best[1], Pose2D(theta=np.pi))
    assert found[1, SCORE] == pytest.approx(found[0, SCORE], rel=0.05)
    assert found[2, SCORE] < 0.5 * found[1, SCORE]


def test_places_are_sorted_and_distinct() -> None:
    found = propose_places(constellation(offices(0)), constellation(offices(1)), most=5)
    assert found.shape == (5, 4)
    assert (np.diff(found[:, SCORE]) <= 0.0).all()
    for k, place in enumerate(found):
        for other in found[:k]:
            off = Pose2D.from_array(place[PLACE_X:]).between(Pose2D.from_array(other[PLACE_X:]))
            assert off.distance(Pose2D()) >= 0.4 or abs(off.theta) >= 0.1


def test_a_corner_scores_more_than_a_longer_corridor() -> None:
    bare, cornered = constellation(CORRIDOR), constellation(np.vstack([CORRIDOR[:, :, :] * [0.5, 1.0], HALL[1:2]]))
    assert propose_places(cornered, cornered)[0, SCORE] > propose_places(bare, bare)[0, SCORE]


def test_without_walls_there_is_no_place() -> None:
    nothing, room = constellation(np.empty((0, 2, 2))), constellation(L_ROOM)
    for a, b in ((nothing, room), (room, nothing), (nothing, nothing)):
        assert propose_places(a, b).shape == (0, 4)


def test_walls_seen_from_the_other_side_are_another_place() -> None:
    seen_from_outside = constellation(L_ROOM[:, ::-1])
    found = propose_places(constellation(L_ROOM), seen_from_outside)
    assert (
        not len(found) or found[0, SCORE] < 0.5 * propose_places(constellation(L_ROOM), constellation(L_ROOM))[0, SCORE]
    )


def test_the_floor_is_free_but_not_near_walls_or_behind() -> None:
    free = constellation(HALL).free
    rows, columns = np.nonzero(free)
    x, y = (columns + 0.5 - CELLS) * CELL, (rows + 0.5 - CELLS) * CELL
    assert abs(x).max() < 4 - 0.3 + CELL
    assert abs(y).max() < 2.5 - 0.3 + CELL
    assert free.sum() * CELL**2 == pytest.approx((8 - 0.6) * (5 - 0.6), rel=0.1)


def test_space_behind_a_wall_is_unknown() -> None:
    back = np.array([[[1.0, 3.0], [1.0, -3.0]]])  # it faces away from the origin
    assert not constellation(np.vstack([HALL, back])).free[:, CELLS + 4 :].any()


def test_a_wall_across_free_floor_is_a_contradiction() -> None:
    screen = np.array([[[0.0, -1.0], [0.0, 1.0]]])
    empty, divided = constellation(HALL), Constellation(constellation(screen).walls, constellation(HALL).free)
    assert contradicted(np.zeros(4), divided, empty) == pytest.approx(2.0)
    assert contradicted(np.zeros(4), empty, divided) == pytest.approx(2.0)
    away = np.array([0.0, 9.0, 0.0, 0.0])
    assert contradicted(away, Constellation(divided.walls, np.zeros_like(empty.free)), empty) == 0.0


@given(POSES)
@settings(max_examples=20, deadline=None)
def test_moving_walls_moves_their_ends(T: Pose2D) -> None:
    ends = T.transform(L_ROOM)
    walls = moved(_in_order(L_ROOM), T.x, T.y, T.theta)
    np.testing.assert_allclose(walls, _in_order(ends), atol=1e-12)


def test_refining_a_place_aligns_the_walls() -> None:
    room, true = constellation(L_ROOM), Pose2D(0.4, -0.3, 0.5)
    near = Pose2D(0.5, -0.2, 0.53)
    places = np.array([[0.0, near.x, near.y, near.theta]])
    weigh_places(places, room, constellation(L_ROOM, true))
    assert_near(places[0], true, 0.02, 0.005)


def test_votes_for_shifts_are_those_of_plain_sums() -> None:
    walls, others = _in_order(offices(0)[:6]), _in_order(offices(0)[2:9])
    votes = shift_votes(walls, others)
    expected = np.zeros_like(votes)
    for a in walls:
        for b in others:
            along = b[[ALONG_X, ALONG_Y]]
            if a[[ALONG_X, ALONG_Y]] @ along <= 0.9925:
                continue
            across, half = np.array([-along[1], along[0]]), 0.5 * (a[LENGTH] + b[LENGTH])
            middle = b[[MIDDLE_X, MIDDLE_Y]] - a[[MIDDLE_X, MIDDLE_Y]]
            for step in range(-200, 201):
                shared = min(half - abs(step) * CELL, a[LENGTH], b[LENGTH], 3.0)
                for side in (-1, 0, 1):
                    column, row = np.floor((middle + CELL * (step * along + side * across)) / CELL).astype(int) + REACH
                    if shared >= 0.1 and 0 <= row < 2 * REACH and 0 <= column < 2 * REACH:
                        information = shared * BLUR[side + 1] * np.outer(across, across)
                        expected[row, column] += information[[0, 0, 1], [0, 1, 1]]
    np.testing.assert_allclose(votes, expected, atol=1e-9)


def test_votes_for_turns_peak_at_the_true_turn() -> None:
    walls = _in_order(offices(0))
    votes = turn_votes(walls, moved(walls, 1.0, 2.0, np.radians(84.0)))
    assert np.argmax(votes) == 42
    assert votes.sum() == pytest.approx(2.5 * np.minimum(walls[:, LENGTH], 3.0).sum() ** 2)


def test_crossing_walls_constrain_more_than_parallel_ones() -> None:
    assert fixedness(0.0, 0.0, 0.0) == 0.0
    assert fixedness(12.0, 0.0, 0.0) < 0.5 * fixedness(6.0, 0.0, 6.0)
    assert fixedness(6.0, 0.0, 6.0) == pytest.approx(6.0)
    c, s = np.cos(0.4), np.sin(0.4)  # the same crossing, turned
    information = 2.0 * np.outer([c, s], [c, s]) + 5.0 * np.outer([-s, c], [-s, c])
    assert fixedness(information[0, 0], information[0, 1], information[1, 1]) == pytest.approx(fixedness(2.0, 0.0, 5.0))


def test_normal_equations_are_those_of_numeric_derivatives() -> None:
    """The plain reference: offset and turn of a wall that slides on another, differentiated by small steps."""
    wall, other = np.array([[1.0, 0.4, 1.0, 0.0, 2.0]]), np.array([[1.2, 0.5, np.cos(0.1), np.sin(0.1), 9.0]])
    pose, normal = np.array([0.1, -0.05, 0.03]), np.array([-np.sin(0.1), np.cos(0.1)])

    def residuals(pose: FloatArray) -> FloatArray:
        there = moved(wall, *pose)[0]
        offset = normal @ (there[[MIDDLE_X, MIDDLE_Y]] - other[0, [MIDDLE_X, MIDDLE_Y]])
        length = wall[0, LENGTH] * np.cos(0.1 - pose[2])
        return np.array([np.sqrt(length) * offset, np.sqrt(length**3 / 12.0) * np.sin(pose[2] - 0.1)])

    wide, pairs = 1e6, np.zeros((1, 2), np.int64)
    information, gradient = normal_equations(moved(wall, *pose), other, pairs, pose[0], pose[1], wide)
    steps = 1e-6 * np.eye(3)
    J = np.column_stack([(residuals(pose + d) - residuals(pose - d)) / 2e-6 for d in steps])
    np.testing.assert_allclose(information, J.T @ J, rtol=0.02)
    np.testing.assert_allclose(gradient, -J.T @ residuals(pose), rtol=0.02)


def test_lengths_on_free_floor_are_those_of_plain_samples() -> None:
    walls, free = _in_order(offices(0)), constellation(HALL).free
    along = np.linspace(-0.5, 0.5, 4001)[:, None]
    expected = 0.0
    for wall in walls:
        points = wall[[MIDDLE_X, MIDDLE_Y]] + along * wall[LENGTH] * wall[[ALONG_X, ALONG_Y]]
        columns, rows = np.floor(points / CELL).astype(int).T + CELLS
        expected += wall[LENGTH] * free[rows, columns].mean()
    assert metres_on(walls, free) == pytest.approx(expected, abs=0.15 * len(walls) * CELL)


def test_voted_places_contain_the_true_place() -> None:
    walls, T = _in_order(L_ROOM), Pose2D(1.1, -0.7, 0.8)
    places = places_voted_for(walls, moved(walls, T.x, T.y, T.theta))
    off = np.hypot(places[:, PLACE_X] - T.x, places[:, PLACE_X + 1] - T.y)
    assert off[np.abs(places[:, HEADING] - T.theta) < 0.05].min() < 2 * CELL


@pytest.mark.parametrize("walls", [L_ROOM, HALL, offices(1)])
def test_voted_places_are_those_of_a_search_of_all_shifts(walls: FloatArray) -> None:
    own, others = _in_order(walls), moved(_in_order(walls), 1.3, -0.4, 0.6)
    places = places_voted_for(own, others)
    for theta in np.unique(places[:, HEADING]):
        votes = shift_votes(moved(own, 0.0, 0.0, theta), others)
        scores = np.sqrt((votes[..., XX] + CHANCE) * (votes[..., YY] + CHANCE) - votes[..., XY] ** 2) - CHANCE
        for place in places[places[:, HEADING] == theta]:
            row, column = np.unravel_index(np.argmax(scores), scores.shape)
            assert place[SCORE] == pytest.approx(scores[row, column], rel=1e-9)
            x, y = (column + 0.5 - REACH) * CELL, (row + 0.5 - REACH) * CELL
            near = max(abs(place[PLACE_X] - x), abs(place[PLACE_X + 1] - y)) < 0.5 * CELL
            assert near or scores.max() == pytest.approx(np.sort(scores, axis=None)[-2], rel=1e-9)  # or an equal one
            row, column = (round(at / CELL - 0.5) + REACH for at in place[[PLACE_X + 1, PLACE_X]])
            rows, columns = (slice(max(at - SHIFTS_APART, 0), at + SHIFTS_APART + 1) for at in (row, column))
            scores[rows, columns] = 0.0


def test_surfels_seen_once_make_walls_in_the_frame_of_the_robot() -> None:
    bearings = np.linspace(-np.pi, np.pi, 721)[:-1]
    with np.errstate(divide="ignore"):
        ranges = np.minimum(4.0 / abs(np.cos(bearings)), 2.5 / abs(np.sin(bearings)))
    scan = LaserScan(0.0, -np.pi, float(bearings[1] - bearings[0]), 0.05, 20.0, ranges)
    surfels, T = SurfelMap(SurfelMapConfig()), Pose2D(30.0, -7.0, 0.0)
    normals = np.array([[4, 0, 1, 0], [-4, 0, -1, 0], [0, 2.5, 0, 1], [0, -2.5, 0, -1]], float)
    facets = np.array(
        [
            [nx * abs(x) + (1 - abs(nx)) * t, ny * abs(y) + (1 - abs(ny)) * t, nx, ny, 1e-4, 5, 0]
            for x, y, nx, ny in normals
            for t in np.arange(-3.9 if ny else -2.4, 3.9 if ny else 2.4, 0.2)
        ]
    )
    surfels.add(facets, scan, T, walls=False)
    seen = Constellation.of_surfels(surfels.surfels, T.as_array(), surfels.config.cell)
    long_walls = seen.walls[seen.walls[:, LENGTH] > 4.0]
    assert len(long_walls) == 4
    assert_near(propose_places(constellation(HALL), seen)[0], Pose2D(), 0.1, np.inf)


def _in_order(ends: FloatArray) -> FloatArray:
    """Make walls (M, 5) with these ends (M, 2, 2), in the same order."""
    lines = ends[:, 1] - ends[:, 0]
    lengths = np.hypot(*lines.T)
    return np.column_stack([ends.mean(axis=1), lines / lengths[:, None], lengths])
