"""The line map against the true walls: faces of the solids, seen parts of them, and the score."""

from typing import Any

import numpy as np
import pytest

from slam.line_slam import Estimate
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.scoring.seen_walls import SeenWalls, _faces_met
from slam.run.scoring.true_walls import TrueWalls, true_walls
from slam.run.scoring.wall_score import WallScore, score_walls, wall_ends, wall_metrics
from slam.run.step import Step
from slam.scan import LaserScan
from slam.scenario.solids import rectangle
from slam.scenario.wall import Door, Wall

DOOR = Wall(points=((0.0, 0.0), (4.0, 0.0)), doors=(Door(at=1.0, angle=0.0),))
BOX = rectangle((2.0, 1.0), 2.0, 1.0, 0.3)


def room(width: float = 4.0, depth: float = 3.0) -> list[FloatArray]:
    """Outlines of the four walls of a room, 0.1 m thick, whose inside begins at the origin."""
    w, d = width + 0.05, depth + 0.05
    wall = Wall(points=((-0.05, -0.05), (w, -0.05), (w, d), (-0.05, d)), closed=True)
    return [prism.footprint for prism in wall.prisms()]


def score(walls: TrueWalls, lines: FloatArray) -> WallScore:
    """Score with all walls seen."""
    return score_walls(walls, np.ones(len(walls.samples), np.bool_), lines)


def line(*numbers: float) -> FloatArray:
    """One line from x, y to x, y."""
    return np.array(numbers).reshape(1, 2, 2)


def test_a_box_has_four_faces_with_their_free_side_to_the_left() -> None:
    walls = true_walls([BOX])
    assert sorted(np.round(walls.lengths, 9)) == [1.0, 1.0, 2.0, 2.0]
    way = walls.faces[:, 1] - walls.faces[:, 0]
    left = np.column_stack([-way[:, 1], way[:, 0]])
    assert np.all(np.sum(left * (walls.faces[:, 0] - BOX.mean(axis=0)), axis=1) > 0.0)
    assert walls.weights.sum() == pytest.approx(6.0)


def test_a_room_has_eight_faces_whatever_its_solids() -> None:
    assert sorted(np.round(true_walls(room()).lengths, 6)) == [3.0, 3.0, 3.2, 3.2, 4.0, 4.0, 4.2, 4.2]


def test_sides_against_another_solid_are_not_faces() -> None:
    left, right = (rectangle((x, 0.5), 1.0, 1.0, 0.0) for x in (0.5, 1.5))
    assert sorted(np.round(true_walls([left, right]).lengths, 6)) == [1.0, 1.0, 2.0, 2.0]
    low = rectangle((1.5, 0.25), 1.0, 0.5, 0.0)  # hides the lower half of the other's side
    assert sorted(np.round(true_walls([left, low]).lengths, 6)) == [0.5, 0.5, 1.0, 1.0, 1.0, 2.0]


def test_a_wall_goes_on_behind_a_thin_wall_to_its_corners() -> None:
    walls = true_walls([*room(), rectangle((1.0, 1.0), 0.1, 2.0, 0.0)])
    inner = (walls.faces[:, :, 1] == 0.0).all(axis=1)
    assert sorted(np.round(walls.lengths[inner], 6)) == [0.95, 2.95]
    assert wall_ends(walls)[inner].sum() == 2
    assert wall_ends(walls)[~inner].all()


def test_a_step_of_a_few_centimetres_does_not_end_a_wall() -> None:
    """A closed door lies 3 cm behind the faces of its wall."""
    walls = true_walls([prism.footprint for prism in DOOR.prisms()])
    long = walls.lengths > 0.2
    assert sorted(np.round(walls.lengths[long], 6)) == [0.9, 0.9, 1.05, 1.05, 2.15, 2.15]
    assert wall_ends(walls)[long].sum() == 4


def test_without_walls_or_a_map_there_is_no_score() -> None:
    walls = true_walls([])
    found = wall_metrics(score(walls, np.empty((0, 2, 2))))
    assert walls.faces.shape == (0, 2, 2)
    assert found["wall_precision"] is None
    assert found["wall_recall"] is None
    assert wall_metrics(score(walls, line(0, 0, 1, 0)))["wall_free_air_m"] == 1.0


def test_a_perfect_map_has_full_precision_and_recall() -> None:
    walls = true_walls([*room(), BOX])
    found = score(walls, walls.faces)
    assert (found.precision, found.recall) == (1.0, 1.0)
    assert found.doubled == pytest.approx(0.0, abs=1e-9)
    assert (found.free_air, found.phantom) == (0.0, 0.0)
    assert np.abs(found.length_errors).max() < 1e-9
    assert len(found.end_errors) == wall_ends(walls).sum() == 2 * len(walls.faces)
    assert found.end_errors.max() < 1e-9


def test_a_displaced_map_is_scored_by_its_offset() -> None:
    walls = true_walls(room())
    near, far = (score(walls, walls.faces + np.array([offset, 0.0])) for offset in (0.06, 0.14))
    assert near.precision == 1.0
    assert np.median(near.end_errors) == pytest.approx(0.06)
    assert far.precision < 0.6
    assert far.recall < 0.6


def test_a_map_one_percent_larger_has_longer_walls() -> None:
    walls = true_walls([BOX])
    middle = BOX.mean(axis=0)
    found = score(walls, middle + 1.01 * (walls.faces - middle))
    assert found.whole_lengths.sum() == pytest.approx(6.0)
    assert found.length_error_share == pytest.approx(0.01)


def test_the_score_is_the_same_in_every_frame() -> None:
    random = np.random.default_rng(3)
    T = Pose2D(3.0, -2.0, 0.7)
    lines = true_walls(room()).faces + 0.03 * random.normal(size=(8, 2, 2))
    moved = T.transform(lines.reshape(-1, 2)).reshape(-1, 2, 2)
    here, there = score(true_walls(room()), lines), score(true_walls([T.transform(o) for o in room()]), moved)
    pairs: Any = zip(here, there, strict=True)
    for a, b in pairs:
        assert np.sort(np.ravel(a)) == pytest.approx(np.sort(np.ravel(b)), abs=1e-9)


def test_two_halves_of_a_line_score_as_the_whole_line() -> None:
    walls = true_walls(room())
    lines = walls.faces + np.array([0.02, -0.03])
    middles = lines.mean(axis=1)
    halves = np.concatenate([np.stack([lines[:, 0], middles], 1), np.stack([middles, lines[:, 1]], 1)])
    whole, split = score(walls, lines), score(walls, halves)
    assert split.recall == whole.recall
    assert split.right == pytest.approx(whole.right, abs=0.04)
    assert split.doubled == pytest.approx(whole.doubled, abs=0.04)


def test_a_second_line_on_a_face_is_doubled() -> None:
    walls = true_walls(room())
    again = np.concatenate([walls.faces, line(1.0, 0.04, 2.0, 0.04)[:, ::-1], line(1.0, 0.04, 2.0, 0.04)])
    found = score(walls, again)
    assert found.doubled == pytest.approx(1.0, abs=0.02)
    assert found.precision < 1.0  # one of the two faces the inside of the wall
    assert found.free_air == 0.0


def test_a_line_far_from_every_wall_is_in_free_air() -> None:
    walls = true_walls(room())
    found = score(walls, np.concatenate([walls.faces, line(1.0, 1.0, 1.6, 1.0), line(2.0, 0.0, 2.0, 0.5)]))
    assert found.free_air == pytest.approx(1.0, abs=0.02)
    assert found.phantom == pytest.approx(0.6, abs=0.02)
    assert found.mapped - found.right == pytest.approx(1.1, abs=0.02)


def test_a_missing_wall_costs_recall_and_short_faces_do_not() -> None:
    walls = true_walls([*room(), rectangle((2.0, 1.5), 0.05, 0.05, 0.0)])
    long = walls.lengths > 0.2
    inner = (np.abs(walls.lengths - 3.0) < 1e-6) & (walls.faces[:, 0, 0] < 0.5)
    assert score(walls, walls.faces[long]).recall == 1.0
    assert score(walls, walls.faces[long & ~inner]).recall == pytest.approx(1.0 - 3.0 / 28.8)


def test_walls_that_were_not_seen_cost_no_recall() -> None:
    walls = true_walls(room())
    seen = walls.samples[:, 0] < 2.0
    found = score_walls(walls, seen, walls.faces)
    assert found.seen == pytest.approx(walls.weights[seen].sum())
    assert found.recall == 1.0
    assert len(found.length_errors) == 2  # the two faces of the left wall


def scan_of(ranges: FloatArray) -> LaserScan:
    return LaserScan(0.0, -np.pi / 2, np.pi / 180, 0.02, 4.0, ranges)


def look(seen: SeenWalls, place: Pose2D, ranges: FloatArray) -> None:
    odometry = Odometry(0.0, place, Twist2D())
    seen.on_step(Step(0, Observation(scan_of(ranges), odometry, place), Estimate(0.0, place), Twist2D(), 0.0))


def test_a_wall_is_seen_from_three_places_by_its_echoes() -> None:
    bearings = np.radians(np.arange(-90.0, 91.0))
    seen = SeenWalls([rectangle((3.05, 0.0), 0.1, 8.0, 0.0)], Pose2D())
    for k in range(3):
        place = Pose2D(0.0, 0.2 * k)
        with np.errstate(over="ignore", divide="ignore"):
            ranges = np.where(np.abs(np.cos(bearings)) > 0.75, 3.0 / np.cos(bearings), np.inf)
        ranges[bearings < 0.0] = 1.0  # somebody stands there
        assert not seen.seen.any()
        for _ in range(3):  # at rest they count once
            look(seen, place, ranges)
    samples = seen.walls.samples[seen.seen]
    assert samples[:, 0] == pytest.approx(3.0)
    assert samples[:, 1].min() == pytest.approx(0.4, abs=0.1)
    assert samples[:, 1].max() == pytest.approx(3.0 * np.tan(np.arccos(0.75)), abs=0.1)
    assert seen.scans.max() == 3


def test_pieces_are_scored_as_by_a_plain_loop() -> None:
    random = np.random.default_rng(7)
    walls = true_walls([*room(), BOX])
    lines = random.uniform([-0.2, -0.2], [4.2, 3.2], (40, 2, 2))
    lines[::2] = walls.faces[random.integers(len(walls.faces), size=20)] + random.normal(0.0, 0.04, (20, 2, 2))
    mapped = right = free = 0.0
    for start, end in lines:
        way = end - start
        length = np.hypot(*way)
        count = int(np.ceil(length / 0.02))
        for k in range(count):
            place = start + way * (k + 0.5) / count
            near = [face for face in walls.faces if distance(place, face) <= 0.10]
            same_way = [
                f for f in near if way @ (f[1] - f[0]) >= np.cos(np.radians(20)) * length * np.hypot(*(f[1] - f[0]))
            ]
            mapped, right = mapped + length / count, right + (length / count if same_way else 0.0)
            free += 0.0 if near else length / count
    found = score(walls, lines)
    assert (found.mapped, found.right, found.free_air) == pytest.approx((mapped, right, free), abs=1e-9)


def distance(place: FloatArray, face: FloatArray) -> float:
    """Distance of a point from a face, plainly."""
    start, way = face[0], face[1] - face[0]
    share = np.clip((place - start) @ way / (way @ way), 0.0, 1.0)
    return float(np.hypot(*(place - start - share * way)))


def test_a_beam_sees_the_nearest_face() -> None:
    walls = true_walls([*room(), BOX])
    origin, angles = np.array([0.5, 0.4]), np.linspace(-np.pi, np.pi, 97)
    beams = np.column_stack([np.cos(angles), np.sin(angles)])
    face, along = _faces_met(origin, beams, np.full(len(beams), np.nan), walls.faces)
    assert np.all(face == -1)  # no echo, nothing seen
    for beam in beams:
        hits = []
        for f, (start, end) in enumerate(walls.faces):
            way = (end - start) / walls.lengths[f]
            if abs(beam @ [-way[1], way[0]]) < 1e-9:
                continue
            r, t = np.linalg.solve(np.column_stack([beam, -way]), start - origin)
            if r > 0.0 and 0.0 <= t <= walls.lengths[f]:
                hits.append((r, f, t, abs(beam @ [-way[1], way[0]])))
        r, f, t, cosine = min(hits)
        face, along = _faces_met(origin, beam[None], np.array([r + 0.05]), walls.faces)
        assert face[0] == (f if cosine >= np.cos(np.radians(75.0)) else -1)
        assert along[0] == pytest.approx(t)
        assert _faces_met(origin, beam[None], np.array([r + 0.1 * max(r, 1.0) + 0.01]), walls.faces)[0][0] == -1
