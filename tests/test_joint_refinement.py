"""Key scans and walls, refined together."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from slam.graph.joint_refinement import RefinementSettings, refine
from slam.graph.main_edges import MainEdges, find_main_edges, no_main_edges
from slam.graph.pose_graph import NO_LOOP, Edges
from slam.graph.refined_walls import RefinedWalls, wall_covariances
from slam.graph.wall_equations import MIN_SCATTER, fit_lines, wall_equations
from slam.graph.wall_landmarks import CELL, TABLE, FoundWalls, PlacedFacets, find_walls
from slam.lines.segments import IntArray
from slam.pose import FloatArray, compose_poses, relative_poses, wrap_angles

SIGMA = 0.004  # standard deviation of a facet along its normal, metres
ODOMETRY = np.array([0.01, 0.01, 0.006])  # standard deviations of a motion, metres and radians
EXACT = RefinementSettings(floor=0.0, correlation=1.0)  # the facets of this file are flat and independent
SOLVED = EXACT._replace(tolerance=1e-8, max_iterations=1000)  # until convergence, so that rounding does not matter


class Run(NamedTuple):
    truth: FloatArray
    start: FloatArray
    edges: Edges
    facets: list[FloatArray]

    @property
    def nodes(self) -> IntArray:
        return np.arange(len(self.truth))

    @property
    def weights(self) -> FloatArray:
        return np.ones(len(self.edges.first))


def corridor_walls() -> FloatArray:
    """Walls (M, 2, 2) of a ring of corridors, 2 m wide, and of a room inside the ring."""
    corners = [
        [(-1.0, -1.0), (11.0, -1.0), (11.0, 7.0), (-1.0, 7.0)],
        [(1.0, 1.0), (9.0, 1.0), (9.0, 5.0), (1.0, 5.0)],
        [(4.0, 2.0), (6.0, 2.0), (6.0, 4.0), (4.0, 4.0)],
    ]
    return np.array([(ring[k], ring[(k + 1) % 4]) for ring in corners for k in range(4)])


def facets_seen(
    pose: FloatArray, walls: FloatArray, noise: np.random.Generator | None, reach: float = 5.0
) -> FloatArray:
    """Facets (F, 7) of all walls within reach, also of those behind others."""
    rows = []
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for start, end in walls:
        length = np.hypot(*(end - start))
        along, count = (end - start) / length, max(int(length / 0.2), 1)
        for k in range(count):
            offset = start + (k + 0.5) * length / count * along - pose[:2]
            if np.hypot(*offset) > reach:
                continue
            normal = np.array([-along[1], along[0]])
            normal *= 1.0 if normal @ offset > 0.0 else -1.0
            offset = offset + (0.0 if noise is None else SIGMA * noise.normal()) * normal
            to_sensor = np.array([[c, s], [-s, c]])
            rows.append((*(to_sensor @ offset), *(to_sensor @ normal), SIGMA**2, 5.0, float(k > 0)))
    return np.array(rows)


def chain(truth: FloatArray, noise: np.random.Generator | None, sigmas: FloatArray = ODOMETRY) -> Edges:
    """Odometry from each pose to the next."""
    measured = relative_poses(truth[:-1], truth[1:])
    if noise is not None:
        measured = measured + sigmas * noise.normal(size=measured.shape)
    count = len(measured)
    information = np.tile(np.diag(1.0 / sigmas**2), (count, 1, 1))
    return Edges(np.arange(count), np.arange(1, count + 1), measured, information, np.full(count, NO_LOOP))


def drive(seed: int | None, step: float = 0.5, walls: FloatArray | None = None) -> Run:
    """Drive once around the corridors with the lidar turned a little aside; without a seed there is no noise."""
    noise = None if seed is None else np.random.default_rng(seed)
    corners = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0], [0.0, 0.0]])
    rows = []
    for a, b in pairwise(corners):
        way = b - a
        ticks = np.arange(0.0, np.hypot(*way), step) / np.hypot(*way)
        rows += [(*(a + t * way + [0.013, 0.027]), np.arctan2(way[1], way[0]) + 0.1) for t in ticks]
    truth = np.array(rows)
    walls = corridor_walls() if walls is None else walls
    edges = chain(truth, noise)
    start = truth[:1].copy()
    for motion in edges.measured:
        start = np.vstack([start, compose_poses(start[-1], motion[None])])
    return Run(truth, start, edges, [facets_seen(pose, walls, noise) for pose in truth])


def refined(run: Run, config: RefinementSettings = EXACT) -> tuple[FloatArray, RefinedWalls]:
    found = refine(run.start, run.edges, run.weights, run.facets, run.nodes, config)
    return found.poses, found.walls


def differences(poses: FloatArray, others: FloatArray) -> FloatArray:
    off = poses - others
    off[:, 2] = wrap_angles(off[:, 2])
    return off


def offsets_from_walls(walls: RefinedWalls, truth: FloatArray) -> FloatArray:
    """Return how far each wall is shifted and turned from the nearest true line, (M, 2)."""
    rows = []
    for start, end in walls.ends:
        along, middle = (end - start) / np.hypot(*(end - start)), 0.5 * (start + end)
        best = []
        for a, b in truth:
            t = (b - a) / np.hypot(*(b - a))
            t = t if t @ along > 0.0 else -t
            best.append(
                ((middle - a) @ np.array([t[1], -t[0]]), np.arctan2(t[0] * along[1] - t[1] * along[0], t @ along))
            )
        rows.append(min(best, key=lambda off: abs(off[0]) + abs(off[1])))
    return np.array(rows)


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.0), (-37.3, 21.7, -2.0), (140.0, 5.1, 3.1)])
def test_a_rigid_motion_moves_the_result_and_nothing_else(place: tuple[float, float, float]) -> None:
    run, motion = drive(1), np.array(place)
    poses, walls = refined(run, SOLVED)
    moved = run._replace(start=compose_poses(motion, run.start))
    others, other_walls = refined(moved, SOLVED)
    assert differences(others, compose_poses(motion, poses)) == pytest.approx(0.0, abs=1e-6)
    ends = np.column_stack([walls.ends.reshape(-1, 2), np.zeros(2 * len(walls.ends))])
    assert other_walls.ends.reshape(-1, 2) == pytest.approx(compose_poses(motion, ends)[:, :2], abs=1e-6)
    assert other_walls.covariance == pytest.approx(walls.covariance, rel=1e-4, abs=1e-12)


def test_a_solver_stopped_early_reduces_the_error() -> None:
    """Each of its iterations goes downhill, so that a few bring the poses a part of the way."""
    run, off = drive(2), list[float]()
    for most in (0, 2, 150):
        poses, _ = refined(run, EXACT._replace(tolerance=0.0, max_iterations=most))
        off.append(float(np.abs(differences(poses, run.truth)[:, :2]).mean()))
    assert off[2] < off[1] < off[0]


def test_exact_data_do_not_move() -> None:
    run = drive(None)
    poses, walls = refined(run)
    assert differences(poses, run.truth) == pytest.approx(0.0, abs=1e-9)
    assert walls.rms == pytest.approx(0.0, abs=1e-9)
    assert offsets_from_walls(walls, corridor_walls()) == pytest.approx(0.0, abs=1e-9)


def test_the_order_of_the_scans_makes_no_difference() -> None:
    run = drive(2)
    poses, _ = refined(run, SOLVED)
    order = np.random.default_rng(0).permutation(len(run.truth))
    facets = [run.facets[k][::-1] for k in order]
    others = refine(run.start, run.edges, run.weights, facets, run.nodes[order], SOLVED).poses
    assert differences(others, poses) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_a_building_bent_by_odometry_is_straightened(seed: int) -> None:
    run = drive(seed)
    before = differences(run.start, run.truth)
    after = differences(refined(run)[0], run.truth)
    assert np.hypot(*before[:, :2].T).max() > 0.05
    assert np.hypot(*after[:, :2].T).max() < 0.012
    assert np.abs(after[:, 2]).max() < 0.003


def test_wall_errors_at_known_poses_fit_their_sigmas() -> None:
    squares = []
    for seed in range(20):
        run = drive(seed, step=1.0)
        known = run._replace(start=run.truth, edges=chain(run.truth, None, np.full(3, 1e-7)))
        _, walls = refined(known, EXACT._replace(directions=False, rounds=2))
        off = offsets_from_walls(walls, corridor_walls())
        squares.append(np.einsum("mi,mij,mj->m", off, np.linalg.inv(walls.covariance), off))
    assert np.mean(np.concatenate(squares)) == pytest.approx(2.0, rel=0.2)


def test_walls_have_the_errors_of_the_poses_that_see_them() -> None:
    """The covariance of a wall includes that of the poses from which it was seen."""
    run = drive(3)
    poses, walls = refined(run)
    covariances = np.tile(np.diag([0.1, 0.1, 0.0]) ** 2, (len(poses), 1, 1))
    found = wall_covariances(walls, poses, covariances)
    assert np.sqrt(found[:, 0, 0]) == pytest.approx(0.1, rel=0.01)
    assert found[:, 1, 1] == pytest.approx(walls.covariance[:, 1, 1])
    turned = np.tile(np.diag([0.0, 0.0, 0.01]) ** 2, (len(poses), 1, 1))
    assert np.all(wall_covariances(walls, poses, turned)[:, 1, 1] > 0.01**2)


def test_a_step_divides_a_wall_into_two_landmarks() -> None:
    step = np.array([[[-3.0, 2.0], [0.0, 2.0]], [[0.0, 2.05], [3.0, 2.05]]])
    straight = np.array([[[-3.0, 2.0], [3.0, 2.0]]])
    for walls, count in ((straight, 1), (step, 2)):
        placed = placed_facets(
            [facets_seen(np.array([x, 0.0, 0.0]), walls, None) for x in (-1.0, 0.0, 1.0)], [-1.0, 0.0, 1.0]
        )
        assert len(find_walls(placed, 0.01, 0.06).lines) == count


def test_the_two_sides_of_a_thin_wall_are_two_landmarks() -> None:
    wall = np.array([[[-2.0, 0.0], [2.0, 0.0]]])
    places = [(0.0, -1.0), (0.5, -1.0), (0.0, 1.0), (0.5, 1.0)]
    facets = [facets_seen(np.array([x, y, 0.0]), wall, None) for x, y in places]
    placed = placed_facets(facets, [x for x, _ in places], [y for _, y in places])
    found = find_walls(placed, 0.01, 0.06)
    assert sorted(found.lines[:, 1].round(6)) == [-1.0, 1.0]


def test_distant_walls_are_two_landmarks() -> None:
    """Both have the same cells in the table of neighbours, which is periodic; still they are not merged."""
    far = TABLE * CELL
    walls = np.array([[[x - 2.0, 1.0], [x + 2.0, 1.0]] for x in (0.0, far)])
    x = [0.0, 0.5, far, far + 0.5]
    placed = placed_facets([facets_seen(np.array([one, 0.0, 0.0]), walls, None) for one in x], x)
    assert len(find_walls(placed, 0.01, 0.06).lines) == 2


def test_a_wall_seen_by_one_scan_is_not_a_landmark() -> None:
    wall = np.array([[[-2.0, 1.0], [2.0, 1.0]]])
    assert len(find_walls(placed_facets([facets_seen(np.zeros(3), wall, None)], [0.0]), 0.01, 0.06).lines) == 0


def test_the_graph_alone_stays_where_it_is_without_facets() -> None:
    run = drive(5)
    found = refine(run.start, run.edges, run.weights, [np.empty((0, 7)) for _ in run.truth], run.nodes)
    assert differences(found.poses, run.start) == pytest.approx(0.0, abs=1e-9)
    assert len(found.walls.ends) == 0


def test_an_empty_graph_is_refined_to_an_empty_graph() -> None:
    found = refine(np.empty((0, 3)), chain(np.zeros((1, 3)), None), np.ones(0), [], np.empty(0, np.int64))
    assert found.poses.shape == (0, 3)
    assert len(wall_covariances(found.walls, found.poses, np.empty((0, 3, 3)))) == 0


def test_a_single_pose_does_not_move() -> None:
    edges = chain(np.zeros((1, 3)), None)
    facets = [facets_seen(np.zeros(3), corridor_walls(), None)]
    found = refine(np.ones((1, 3)), edges, np.ones(0), facets, np.zeros(1, np.int64))
    assert found.poses == pytest.approx(np.ones((1, 3)))
    assert found.rounds == 0


def test_main_directions_align_a_rotated_wing() -> None:
    """Two rooms have no wall in common; the turn of the motion from one to the other is wrong by a degree."""
    rooms = [[(0.0, -2.0), (6.0, -2.0)], [(6.0, 2.0), (0.0, 2.0)], [(0.0, 2.0), (0.0, -2.0)], [(6.0, -2.0), (6.0, 2.0)]]
    walls = np.array([[(x + dx, y) for x, y in wall] for dx in (0.0, 20.0) for wall in rooms])
    truth = np.array([(x + dx, 0.0, 0.0) for dx in (0.0, 20.0) for x in np.linspace(1.0, 5.0, 9)])
    edges = chain(truth, None)
    edges.measured[8, 2] += np.radians(1.0)
    edges.information[8] = np.diag(np.array([0.1, 0.1, 0.05]) ** -2)
    start = truth.copy()
    start[9:] = compose_poses(compose_poses(truth[8], edges.measured[8:9]), relative_poses(truth[9], truth[9:]))
    facets = [facets_seen(pose, walls, np.random.default_rng(k)) for k, pose in enumerate(truth)]
    off = {}
    for held in (True, False):
        found = refine(start, edges, np.ones(len(edges.first)), facets, np.arange(18), EXACT._replace(directions=held))
        off[held] = np.degrees(np.abs(found.poses[9:, 2])).max()
    assert off[False] > 0.9
    assert off[True] < 0.1


def test_the_walls_are_eliminated_as_in_a_dense_system() -> None:
    run = drive(6, step=2.0)
    run = run._replace(start=run.truth + 0.003)
    placed = facets_at(run.start, run.facets)
    walls = find_walls(placed, 0.02, 0.1)
    walls = walls._replace(lines=fit_lines(placed, walls, 0.05))
    theta = np.arctan2(walls.lines[:, 1], walls.lines[:, 0])
    for main in (no_main_edges(len(theta)), find_main_edges(theta, np.full(len(theta), 6.0), walls.lines[:, 2:])):
        S, gradient = dense_system(placed, walls, main, 0.05, len(run.truth))
        equations = wall_equations(placed, run.nodes, walls, main, 0.05, len(run.truth))
        applied = [equations.apply(row.reshape(-1, 3)).ravel() for row in np.eye(len(S))]
        assert np.array(applied) == pytest.approx(S, rel=1e-6, abs=1e-4 * np.abs(S).max() * 1e-4)
        assert equations.gradient.ravel() == pytest.approx(gradient, rel=1e-6, abs=1e-8 * np.abs(gradient).max())


def placed_facets(facets: list[FloatArray], x: list[float], y: list[float] | None = None) -> PlacedFacets:
    """The facets of scans with heading 0 at these places."""
    return facets_at(np.column_stack([x, y or np.zeros(len(x)), np.zeros(len(x))]), facets)


def facets_at(poses: FloatArray, facets: list[FloatArray]) -> PlacedFacets:
    scans = np.repeat(np.arange(len(facets)), [len(one) for one in facets])
    rows = np.concatenate(facets)
    at, turn = poses[scans], poses[scans] * [0.0, 0.0, 1.0]
    levers, normals = (
        compose_poses(turn, np.column_stack([rows[:, k : k + 2], np.zeros(len(rows))]))[:, :2] for k in (0, 2)
    )
    return PlacedFacets(at[:, :2] + levers, normals, levers, rows[:, 4].copy(), scans)


def dense_system(
    placed: PlacedFacets, walls: FoundWalls, main: MainEdges, kernel: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """S and the gradient for the poses, from a plain matrix of poses, walls and main directions."""
    M, K = len(walls.lines), main.direction.max(initial=-1) + 1
    size = 3 * count + 2 * M + K
    H, g = np.zeros((size, size)), np.zeros(size)

    def add(J: FloatArray, w: float, r: float) -> None:
        H[:] += w * np.outer(J, J)
        g[:] += w * r * J

    for m, (nx, ny, cx, cy) in enumerate(walls.lines):
        total = 0.0
        for f in walls.facets[walls.begins[m] : walls.begins[m + 1]]:
            (dx, dy), (lx, ly) = placed.points[f] - (cx, cy), placed.levers[f]
            r, v = nx * dx + ny * dy, placed.variances[f]
            w = 1.0 / (v * (1.0 + r * r / (kernel**2 + v)) ** 2)
            J = np.zeros(size)
            J[3 * placed.scans[f] : 3 * placed.scans[f] + 3] = nx, ny, lx * ny - ly * nx
            J[3 * count + 2 * m : 3 * count + 2 * m + 2] = -1.0, nx * dy - ny * dx
            add(J, w, r)
            total += w
        H[3 * count + 2 * m + 1, 3 * count + 2 * m + 1] += MIN_SCATTER**2 * total
        if main.direction[m] >= 0:
            J = np.zeros(size)
            J[3 * count + 2 * m + 1], J[3 * count + 2 * M + main.direction[m]] = 1.0, -1.0
            add(J, main.information[m], main.error[m])
    n = 3 * count
    reduce = H[:n, n:] @ np.linalg.inv(H[n:, n:])
    return H[:n, :n] - reduce @ H[n:, :n], g[:n] - reduce @ g[n:]
