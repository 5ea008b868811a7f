"""Loop candidates from walls alone, between submaps of rooms with known places."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.graph.submap import Submap
from slam.graph.wall_candidates import MAX_CANDIDATES, MAX_PAIRS, MAX_PLACES, WallCandidates
from slam.mapping.surfel_grid import BORN, COLUMNS, HITS, INFORMATION, NX, NY, X, Y
from slam.pose import FloatArray, Pose2D, stack_poses

CELL = 0.2
L_ROOM = np.array([(-3, -2), (4, -2), (4, 1), (1, 1), (1, 4), (-3, 4)], float)
HALL = np.array([(-4, -2.5), (4, -2.5), (4, 2.5), (-4, 2.5)])
ALONG_L_ROOM = [Pose2D(-2.0, 3.0, -1.5), Pose2D(-1.0, 0.0, -0.8), Pose2D(0.0, -0.5, 0.0), Pose2D(3.0, -0.5, 0.1)]
IN_HALL = [Pose2D(-2.0), Pose2D(0.0), Pose2D(2.0)]
DRIFTS = st.builds(Pose2D, st.floats(-30, 30), st.floats(-30, 30), st.floats(-3.1, 3.1))


def surfels_of(corners: FloatArray, T_local_world: Pose2D) -> FloatArray:
    """One surfel every 0.1 m of the walls of a room, corners counter-clockwise, frame ``local``."""
    rows = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.hypot(*(end - start)))
        along = (end - start) / length
        for way in np.arange(0.05, length, 0.1):
            row = np.zeros(COLUMNS)
            row[[X, Y]], row[[NX, NY]] = start + way * along, (along[1], -along[0])
            rows.append(row)
    surfels = np.array(rows)
    surfels[:, [X, Y]] = T_local_world.transform(surfels[:, [X, Y]])
    surfels[:, [NX, NY]] = surfels[:, [NX, NY]] @ T_local_world.rotation.T
    surfels[:, INFORMATION], surfels[:, HITS], surfels[:, BORN] = 1e4, 5.0, 0.0
    return surfels


def submap_of(number: int, path: list[Pose2D], T_local_world: Pose2D) -> Submap:
    local = stack_poses(T_local_world @ pose for pose in path)
    return Submap(number, number, local[0], False, list(range(len(path))), local)


def known(rooms: list[tuple[FloatArray, list[Pose2D], Pose2D]]) -> tuple[WallCandidates, list[Submap]]:
    """Submaps of rooms, each driven along a path; for each room, ``local`` has its own drift, ``T_local_world``."""
    candidates, submaps = WallCandidates(), []
    for number, (corners, path, T_local_world) in enumerate(rooms):
        submaps.append(submap_of(number, path, T_local_world))
        candidates.add(submaps[-1], surfels_of(corners, T_local_world), CELL)
    return candidates, submaps


@settings(max_examples=20, deadline=None)
@given(DRIFTS, DRIFTS)
def test_a_room_is_recognized_whatever_the_drift(T_first_world: Pose2D, T_last_world: Pose2D) -> None:
    """The room is driven the other way, and the drift of the frame is unknown to the search."""
    back = [pose @ Pose2D(theta=np.pi) for pose in reversed(ALONG_L_ROOM)]
    rooms = [(HALL, IN_HALL, Pose2D()), (L_ROOM, ALONG_L_ROOM, T_first_world), (L_ROOM, back, T_last_world)]
    candidates, (hall, first, last) = known(rooms)
    best = candidates.of(last, [hall, first])[0]
    assert best.other is first
    off = (T_first_world @ T_last_world.inverse()).between(Pose2D.from_array(best.T_other_submap))
    middle = Pose2D.from_array(last.path[len(last.path) // 2])
    at_robot = middle.inverse() @ off @ middle
    assert at_robot.distance(Pose2D()) < 0.05
    assert abs(at_robot.theta) < 0.02


def test_a_hall_is_proposed_in_both_orientations() -> None:
    candidates, (first, last) = known([(HALL, IN_HALL, Pose2D(5.0, 1.0, 0.3)), (HALL, IN_HALL, Pose2D())])
    two = candidates.of(last, [first])[:2]
    places = stack_poses(Pose2D.from_array(one.T_other_submap) for one in two)
    np.testing.assert_allclose(places[:, :2], [[5.0, 1.0], [5.0, 1.0]], atol=0.05)
    np.testing.assert_allclose(sorted(places[:, 2]), [0.3 - np.pi, 0.3], atol=0.02)
    assert two[1].score == pytest.approx(two[0].score, rel=0.05)


def test_candidates_are_few_and_sorted_best_first() -> None:
    candidates, submaps = known([(HALL, IN_HALL, Pose2D(float(k), 0.0, 0.1 * k)) for k in range(6)])
    found = candidates.of(submaps[-1], submaps[:-1])
    assert len(found) == MAX_CANDIDATES < MAX_PLACES * len(submaps)
    scores = [one.score for one in found]
    assert scores == sorted(scores, reverse=True)
    assert len(candidates.of(submaps[-1], submaps[:1])) <= MAX_PLACES


def test_only_the_first_of_many_submaps_are_compared() -> None:
    far = [(HALL, IN_HALL, Pose2D(float(k))) for k in range(MAX_PAIRS)]
    candidates, submaps = known([*far, (L_ROOM, ALONG_L_ROOM, Pose2D()), (L_ROOM, ALONG_L_ROOM, Pose2D(1.0))])
    *halls, room, last = submaps
    assert candidates.of(last, [room, *halls])[0].other is room
    assert all(one.other is not room for one in candidates.of(last, [*halls, room]))


def test_submaps_removed_from_the_graph_are_dropped() -> None:
    candidates, (first, last) = known([(L_ROOM, ALONG_L_ROOM, Pose2D()), (L_ROOM, ALONG_L_ROOM, Pose2D(3.0))])
    candidates.keep({last.number})
    assert candidates.of(last, []) == []
    with pytest.raises(KeyError):
        candidates.of(last, [first])
