"""The line map: each wall once, along its whole seen length, and with corners."""

from collections.abc import Iterable
from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slam.config import SlamConfig, SurfelMapConfig
from slam.deskew import deskewed
from slam.lines.extraction import extract_segments
from slam.lines.facets import facets_of
from slam.mapping.free_beams import beam_towards, free_beams
from slam.mapping.free_space import carve
from slam.mapping.surfel_map import SurfelMap
from slam.mapping.wall_corners import meet_at_corners
from slam.mapping.wall_doubles import without_doubles
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

BEAMS, INCREMENT = 720, 2.0 * pi / 720


def outline(*corners: tuple[float, float]) -> FloatArray:
    """The walls (W, 2, 2) between these corners, and back to the first."""
    return np.stack([np.array(corners, float), np.roll(np.array(corners, float), -1, axis=0)], axis=1)


def leg(x: float, y: float) -> FloatArray:
    return outline((x, y), (x + 0.05, y), (x + 0.05, y + 0.05), (x, y + 0.05))


ROOM = outline((-2, -1.5), (2, -1.5), (2, 1.5), (-2, 1.5))
GROWING = ("head", "next", "surfels", "counts", "evidence")
WALL = np.array([[[-0.5, 1.0], [0.5, 1.0]]])


def scan_of(walls: FloatArray, pose: Pose2D, noise: float = 0.004, seed: int = 0) -> LaserScan:
    bearings = INCREMENT * np.arange(BEAMS) - pi
    start, along = walls[:, 0] - pose.translation, walls[:, 1] - walls[:, 0]
    d = np.stack([np.cos(bearings + pose.theta), np.sin(bearings + pose.theta)], axis=1)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
        r = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        t = (start[:, 0] * d[..., 1] - start[:, 1] * d[..., 0]) / cross
        r = np.where((r > 0) & (t >= 0) & (t <= 1), r, np.inf).min(axis=1)
    ranges = r + noise * np.random.default_rng(seed).normal(size=BEAMS)
    return LaserScan(0.0, -pi, INCREMENT, 0.05, 8.0, np.where(r < 8.0, ranges, np.inf))


def see(surfels: SurfelMap, walls: FloatArray, poses: Iterable[Pose2D], error: Pose2D | None = None) -> None:
    """Map the scans of these poses, all of which are wrong by the error."""
    for k, pose in enumerate(poses):
        scan = scan_of(walls, pose, seed=k)
        facets = facets_of(scan, extract_segments(scan, SlamConfig().lines), 0.2)
        surfels.add(facets, scan, pose if error is None else error @ pose)


def around(x: float = 0.0, y: float = 0.0, scans: int = 16, radius: float = 0.5) -> list[Pose2D]:
    angles = 2.0 * pi * np.arange(scans) / scans
    return [Pose2D(x + radius * cos(a), y + radius * sin(a), float(a)) for a in angles]


def mapped(walls: FloatArray, poses: Iterable[Pose2D]) -> FloatArray:
    surfels = SurfelMap(SurfelMapConfig())
    see(surfels, walls, poses)
    return surfels.ends


def lengths(ends: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*(ends[:, 1] - ends[:, 0]).T))


def between(ends: FloatArray, low: tuple[float, float], high: tuple[float, float]) -> FloatArray:
    """Return the segments of which a part lies in this rectangle."""
    part = np.linspace(0.0, 1.0, 101)[:, None]
    inside = [
        np.all(((1 - part) * a + part * b > low) & ((1 - part) * a + part * b < high), axis=1).any() for a, b in ends
    ]
    return np.asarray(ends[np.array(inside, bool)])


@pytest.mark.parametrize("turn", [0.0, 0.3, pi / 4])
def test_a_room_is_four_walls_that_meet(turn: float) -> None:
    world = Pose2D(0.0, 0.0, turn)
    ends = mapped(world.transform(ROOM.reshape(-1, 2)).reshape(-1, 2, 2), around())
    assert len(ends) == 4
    corners = world.transform(ROOM[:, 0])
    off = np.hypot(*np.moveaxis(ends.reshape(-1, 1, 2) - corners, -1, 0))
    assert off.min(axis=1).max() < 0.03
    assert (np.bincount(off.argmin(axis=1)) == 2).all()


def test_no_wall_is_drawn_between_two_legs() -> None:
    for gap in (0.15, 0.3, 0.75):
        world = np.concatenate([ROOM, leg(0.8, 0.0), leg(0.8, gap)])
        ends = mapped(world, around(scans=40))
        assert not len(between(ends, (0.7, 0.06), (1.0, gap - 0.01))), gap


def test_a_thin_wall_seen_from_both_sides_is_two() -> None:
    thin = outline((-1.0, 0.0), (1.0, 0.0), (1.0, 0.06), (-1.0, 0.06))
    ends = mapped(np.concatenate([ROOM, thin]), [*around(0.0, -0.8), *around(0.0, 0.8)])
    faces = ends[(np.abs(ends[:, :, 1] - 0.03) < 0.06).all(axis=1)]
    faces = faces[lengths(faces) > 1.0]
    assert sorted(np.round(faces[:, :, 1].mean(axis=1), 2).tolist()) == [0.0, 0.06]
    assert (faces[0, 1, 0] - faces[0, 0, 0]) * (faces[1, 1, 0] - faces[1, 0, 0]) < 0.0


@pytest.mark.parametrize("width", [0.3, 0.8])
def test_a_door_stays_open(width: float) -> None:
    half = 0.5 * width
    wall = np.array([[[-2, 0], [-half, 0]], [[half, 0], [2, 0]]], float)
    ends = mapped(np.concatenate([ROOM, wall]), around(0.0, -0.8, scans=30))
    jambs = np.sort(np.abs(between(ends, (-1.9, -0.05), (1.9, 0.05))[:, :, 0]), axis=1)[:, 0]
    np.testing.assert_allclose(jambs, half, atol=0.05)


def test_a_wall_is_removed_when_seen_through() -> None:
    surfels, box = SurfelMap(SurfelMapConfig()), outline((0.9, -0.4), (1.2, -0.4), (1.2, 0.4), (0.9, 0.4))
    see(surfels, np.concatenate([ROOM, box]), around(-0.6))
    assert len(between(surfels.ends, (0.8, -0.5), (1.3, 0.5)))
    see(surfels, ROOM, around(-0.6, scans=40))
    assert not len(between(surfels.ends, (0.8, -0.5), (1.3, 0.5)))
    assert len(surfels.ends) == 4


def test_a_wall_doubled_by_a_wrong_pose_is_one_wall() -> None:
    surfels = SurfelMap(SurfelMapConfig())
    see(surfels, ROOM, around(scans=30))
    see(surfels, ROOM, around(scans=5), Pose2D(0.14, 0.0, 0.0))
    assert len(surfels.ends) == 4


def test_walls_do_not_depend_on_when_they_are_read() -> None:
    surfels, again = SurfelMap(SurfelMapConfig()), SurfelMap(SurfelMapConfig())
    for pose in around():
        see(surfels, ROOM, [pose])
        assert np.isfinite(surfels.ends).all()
        see(again, ROOM, [pose])
    np.testing.assert_array_equal(surfels.ends, again.ends)
    np.testing.assert_array_equal(surfels.ends, surfels.ends)


def test_the_free_side_of_a_wall_is_to_its_left() -> None:
    ends = mapped(ROOM, around())
    ways, inwards = ends[:, 1] - ends[:, 0], -ends.mean(axis=1)
    assert (ways[:, 0] * inwards[:, 1] - ways[:, 1] * inwards[:, 0] > 0.0).all()


def test_a_surface_only_grazed_is_not_a_wall() -> None:
    """Posts in a row, whose ends lie almost along the beams."""
    posts = [leg(1.0 + 0.2 * k, -0.5 - 0.03 * k) for k in range(12)]
    assert not len(mapped(np.concatenate(posts), [Pose2D(0.05 * k, -0.4) for k in range(10)]))


def test_an_empty_map_has_no_walls() -> None:
    assert SurfelMap(SurfelMapConfig()).ends.shape == (0, 2, 2)


@given(st.lists(st.tuples(*[st.floats(-2, 2)] * 4), max_size=12))
def test_merging_doubles_creates_no_new_wall(rows: list[tuple[float, float, float, float]]) -> None:
    ends = np.array(rows).reshape(-1, 2, 2)
    ends = ends[lengths(ends) > 0.2]
    kept = without_doubles(ends, lengths(ends), 0.2)
    assert lengths(kept).sum() <= lengths(ends).sum() + 1e-9
    assert (lengths(kept) >= 0.2 - 1e-9).all()
    if len(ends):
        np.testing.assert_allclose(kept[0], ends[np.argmax(lengths(ends))], atol=1e-12)


def test_the_stronger_of_two_parallel_walls_is_kept() -> None:
    longer, beside = WALL * [3.0, 1.0], np.array([0.0, 0.2])
    kept = without_doubles(np.concatenate([WALL - beside, longer]), np.array([1.0, 2.0]), 0.2)
    np.testing.assert_allclose(kept, longer)
    kept = without_doubles(np.concatenate([WALL, longer - beside]), np.array([9.0, 2.0]), 0.2)
    np.testing.assert_allclose(lengths(kept), [1.0, 1.0, 1.0])
    for other in (WALL[:, ::-1] - 0.3 * beside, WALL - 2.0 * beside):  # the other face; too far off
        assert len(without_doubles(np.concatenate([WALL, other]), np.array([1.0, 2.0]), 0.2)) == 2


def test_ends_are_joined_only_within_reach() -> None:
    for gap, meets in ((0.05, True), (-0.15, True), (0.15, False), (0.5, False)):
        other = np.array([[[0.5 + gap, 0.95], [0.5 + gap, -1.0]]])
        met = meet_at_corners(np.concatenate([WALL, other]))
        at = [0.5 + gap, 1.0] if meets else [0.5, 1.0]
        np.testing.assert_allclose(met[0, 1], at)
        np.testing.assert_allclose(met[0, 0], WALL[0, 0])


@given(st.floats(-pi, pi), st.floats(-1.5, 1.5), st.floats(0.0, 1.0))
def test_a_beam_is_found_in_the_fan_of_a_turning_sensor(heading: float, turning: float, driving: float) -> None:
    scan = replace(scan_of(ROOM, Pose2D()), time_increment=0.1 / BEAMS)
    beams = free_beams(deskewed(scan, Twist2D(driving, turning), Pose2D()), 4.0)
    for j in range(30, BEAMS - 30, 37):
        bearing = beams.fan[0, j] + heading
        assert beam_towards(beams, np.array([0.0, 0.0, heading]), 3.0 * cos(bearing), 3.0 * sin(bearing)) == j


READINGS = st.sampled_from([np.inf, -np.inf, np.nan, 0.01, 0.02, 3.9, 5.6, 5.7]) | st.floats(0.0, 8.0)


@given(st.lists(READINGS, min_size=1, max_size=80))
def test_free_ranges_and_echoes_are_those_of_the_scan(readings: list[float]) -> None:
    scan = replace(scan_of(ROOM, Pose2D()), range_min=0.02, range_max=5.6, ranges=np.array(readings))
    beams = free_beams(scan, 4.0)
    np.testing.assert_array_equal(beams.echoes, scan.echoes)
    np.testing.assert_array_equal(beams.ranges[scan.echoes], scan.ranges[scan.echoes])
    np.testing.assert_array_equal(beams.ranges[~scan.echoes], np.where(scan.ranges == np.inf, 4.0, 0.0)[~scan.echoes])
    assert beams.farthest.max() == beams.ranges.max()


def test_an_end_behind_a_better_wall_is_removed() -> None:
    askew = np.array([[[0.0, 0.65], [0.2, 1.35]]])
    through = np.array([[[0.0, 0.1], [0.2, 1.8]]])  # too far through the wall to be a stub
    met = meet_at_corners(np.concatenate([WALL, askew, through]))
    assert np.allclose(met[0], WALL[0])
    assert np.allclose(met[1], [[0.1, 1.0], [0.2, 1.35]])  # the lidar is on the left of a wall
    assert np.allclose(met[2], through[0])
    assert np.allclose(meet_at_corners(np.concatenate([askew, WALL]))[0], askew[0])  # the better one stays as it is


def test_the_test_for_hidden_walls_changes_nothing() -> None:
    surfels = SurfelMap(SurfelMapConfig())
    world = np.concatenate([ROOM, leg(0.8, 0.0), outline((-1.0, 0.0), (0.0, 0.9), (0.0, 1.0), (-1.0, 0.1))])
    see(surfels, world, around())
    for k, pose in enumerate(around(0.3, -0.2, 7, 0.9)):
        beams = free_beams(scan_of(ROOM if k % 2 else world, pose, seed=k), 4.0)
        quick, whole = (
            surfels.grid._replace(**{n: getattr(surfels.grid, n).copy() for n in GROWING}) for _ in range(2)
        )
        carve(quick, beams, pose.as_array(), 8.0, 0.1, 0.0)
        carve(whole, beams._replace(farthest=np.full(1, np.inf)), pose.as_array(), 8.0, 0.1, 0.0)
        np.testing.assert_array_equal(quick.surfels, whole.surfels)
