"""A run that continues in the closed map of another: both are one graph, in which loops are closed."""

from collections.abc import Callable, Collection, Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.errors import InputError
from slam.files.graphs.file import read_graph, write_graph
from slam.files.graphs.key_scans import read_known_graph, write_key_scans
from slam.graph.back_end import BackEnd
from slam.graph.closure import ClosedRun
from slam.graph.known_graph import KnownGraph
from slam.graph.run_graph import RunGraph
from slam.graph.submap_mapper import SubmapMapper
from slam.line_slam import Estimate, LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.saved_slam import SavedSlam, relocate, save
from slam.scan import LaserScan
from tests.ring import around, ranges_from
from tests.test_loop_closing import BEARINGS

PATH = around(2.0)
LAP, BEGIN = len(around(1.0)), len(around(0.75)) - 1
"""Number of scans in a lap of the ring, and index of the scan at which the second run begins."""
END = LAP + len(around(0.25))
BLIND = range(len(around(0.25)) + 10, len(around(0.25)) + 30)
"""Scans of the first run that see nothing while its wheels turn 8 degrees too far: what comes after lies askew."""
AUTO, NEVER = SlamConfig(), SlamConfig(loops="never")
Alter = Callable[[dict[str, np.ndarray]], None]


@dataclass(frozen=True)
class Driven:
    """A run along a part of the ring, with its closed map."""

    estimates: list[Estimate]
    closed: ClosedRun
    saved: SavedSlam
    begin: int

    @property
    def error(self) -> float:
        """Root mean square distance of the closed trajectory from the truth, metres."""
        local = stack_poses(estimate.T_local_base for estimate in self.estimates)
        return rms(self.closed.trajectory(local), PATH[self.begin :])


def rms(poses: FloatArray, truth: list[Pose2D]) -> float:
    return float(np.sqrt(np.mean(np.sum((poses - stack_poses(truth[: len(poses)]))[:, :2] ** 2, axis=1))))


def drive(slam: LineSlam, begin: int, end: int, blind: Collection[int] = ()) -> Iterator[Estimate]:
    """Drive with wheels that turn by two degrees a metre too far."""
    random, wheels = np.random.default_rng(begin), Pose2D()
    for k in range(begin, end):
        if k > begin:
            motion = PATH[k - 1].between(PATH[k])
            turn = motion.theta + np.radians(2.0) * motion.distance(Pose2D())
            wheels = wheels @ Pose2D(1.02 * motion.x, motion.y, turn)
        ranges = ranges_from(PATH[k], BEARINGS) + random.normal(0.0, 0.01, len(BEARINGS))
        ranges[(ranges > 4.0) | (k in blind)] = np.inf
        scan = LaserScan(0.1 * k, float(BEARINGS[0]), 0.02, 0.05, 4.0, ranges)
        yield slam.update(scan, Odometry(0.1 * k, wheels))


def finished(slam: LineSlam, estimates: list[Estimate], closed: ClosedRun | None, begin: int) -> Driven:
    assert closed is not None
    saved = save(slam, closed)
    assert saved is not None
    return Driven(estimates, closed, replace(saved, graph=KnownGraph.of_run(closed)), begin)


def driven(
    slam: LineSlam, begin: int, end: int, known: KnownGraph | None = None, blind: Collection[int] = ()
) -> Driven:
    """Drive, and close loops afterwards, in this process."""
    slam.loops, mapper = None, slam.mapper
    assert isinstance(mapper, SubmapMapper)
    back_end, estimates = BackEnd(mapper.config, mapper.map.config, known), []
    for index, estimate in enumerate(drive(slam, begin, end, blind)):
        estimates.append(estimate)
        if mapper.key is not None:
            back_end.take(replace(mapper.key, index=index))
    return finished(slam, estimates, back_end.finish(np.zeros(3)), begin)


def continued(saved: SavedSlam, place: Pose2D, begin: int, end: int) -> Driven:
    """Continue a saved map from scan ``begin`` on; the map is copied, as the run changes it."""
    return driven(relocate(AUTO, Pose2D(), deepcopy(saved), place), begin, end, saved.graph)


@cache
def first() -> Driven:
    """Three sides of the ring, the third one askew: nothing is seen again."""
    return driven(LineSlam(AUTO, Pose2D(), PATH[0]), 0, BEGIN + 1, blind=BLIND)


@cache
def second() -> Driven:
    """The last side and the first one again, in the map of the first run, as a robot drives."""
    saved = deepcopy(first().saved)
    slam = relocate(AUTO, Pose2D(), saved, saved.T_map_base)
    estimates = list(drive(slam, BEGIN, END))
    return finished(slam, estimates, slam.finish(), BEGIN)


def old_part(driven: Driven, before: Driven) -> tuple[FloatArray, FloatArray]:
    """Return the poses, before and after a continued run, of the key scans of the earlier run that it has kept."""
    past = int(before.closed.indices.max()) + 1
    place = dict(zip((before.closed.indices - past).tolist(), before.closed.poses, strict=True))
    old = driven.closed.indices < 0
    return np.array([place[k] for k in driven.closed.indices[old].tolist()]), driven.closed.poses[old]


def test_a_ring_driven_in_two_runs_is_closed() -> None:
    closed, numbers = second().closed, {submap.number for submap in first().closed.submaps}
    across = np.array([loop.other in numbers and loop.submap not in numbers for loop in closed.loops])
    assert (closed.weights[across] > 0.5).sum() >= 2
    assert second().error < 0.06


def test_the_old_part_is_corrected_to_its_true_place() -> None:
    truth = [PATH[k] for k in first().closed.indices]
    before, after = old_part(second(), first())
    assert len(before) == len(truth)
    assert rms(before, truth) > 0.5
    assert rms(after, truth) < 0.25 * rms(before, truth)


def test_two_runs_are_hardly_worse_than_one() -> None:
    whole = driven(LineSlam(AUTO, Pose2D(), PATH[0]), 0, END, blind=BLIND)
    _, old = old_part(second(), first())
    error = rms(old, [PATH[k] for k in first().closed.indices])
    assert error < 1.5 * whole.error
    assert second().error < 1.5 * whole.error
    assert abs(len(second().closed.map) - len(whole.closed.map)) < 0.1 * len(whole.closed.map)


def test_the_pose_jumps_at_a_closure_in_the_other_process() -> None:
    moved = [k for k, estimate in enumerate(second().estimates) if estimate.closure is not None]
    live = [estimate.T_map_base for estimate in second().estimates]
    assert moved
    assert live[-1].distance(PATH[END - 1]) < 0.2 < 0.5 * live[0].distance(PATH[BEGIN])


def test_revisiting_a_place_does_not_grow_the_graph() -> None:
    saved, sizes = second().saved, list[int]()
    for _ in range(2):
        again = continued(saved, PATH[0], 0, LAP)
        assert again.error < 0.1
        saved = again.saved
        sizes.append(again.closed.size.keys)
    assert sizes[1] - sizes[0] < 0.3 * len(first().closed.keys)  # the end of the last lap is not judged yet


@pytest.mark.parametrize("offset", [Pose2D(2.0), Pose2D(1.4, 1.4, 0.5)])
def test_a_wrong_start_does_not_bend_the_old_map(offset: Pose2D) -> None:
    wrong = continued(second().saved, PATH[10] @ offset, 10, 90)
    before, after = old_part(wrong, second())
    assert np.hypot(*(after - before)[:, :2].T).max() < 0.1
    assert wrong.error < 0.15


def test_the_pose_is_known_before_any_loop_is_closed() -> None:
    saved = deepcopy(first().saved)
    slam = relocate(AUTO, Pose2D(), saved, saved.T_map_base @ Pose2D(0.04, 0.04, 0.03))
    place = saved.T_map_base @ PATH[BEGIN].between(PATH[BEGIN + 2])
    estimates = list(drive(slam, BEGIN, BEGIN + 3))
    assert all(estimate.closure is None for estimate in estimates)
    assert estimates[-1].T_map_base.distance(place) < 0.05
    assert len(slam.points) >= len(first().saved.mapper.map)


def test_without_loops_or_a_graph_the_map_is_unchanged() -> None:
    bare = replace(first().saved, graph=None)
    slams = [
        relocate(NEVER, Pose2D(), deepcopy(first().saved), PATH[BEGIN]),
        relocate(AUTO, Pose2D(), deepcopy(bare), PATH[BEGIN]),
    ]
    one, other = (list(drive(slam, BEGIN, BEGIN + 20)) for slam in slams)
    assert all(slam.loops is None and slam.finish() is None for slam in slams)
    assert stack_poses(e.T_map_base for e in one).tolist() == stack_poses(e.T_map_base for e in other).tolist()


def written(folder: Path) -> tuple[Path, RunGraph]:
    closed = second().closed
    write_graph(folder / "graph.json", RunGraph.of(closed))
    write_key_scans(folder / "key_scans.npz", closed.keys)
    return folder / "key_scans.npz", read_graph(folder / "graph.json")


def test_a_saved_graph_is_read_back_unchanged(tmp_path: Path) -> None:
    read, kept = read_known_graph(*written(tmp_path)), second().saved.graph
    assert kept is not None
    assert len(read.keys) == len(kept.keys)
    for one, other in zip(read.keys, kept.keys, strict=True):
        for name in ("index", "submaps", "lidar", "agreeing_share"):
            assert getattr(one, name) == getattr(other, name), name
        for name in ("T_local_laser", "facets", "ranges", "information", "wheel_motion"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert len(read.edges) + len(read.ties) == len(read.graph.edges.first)
    assert max(key.index for key in read.keys) < 0


def _one_less(arrays: dict[str, np.ndarray]) -> None:
    arrays["share"] = arrays["share"][1:]


def _more_beams(arrays: dict[str, np.ndarray]) -> None:
    arrays["beams"][0] += 1


def _later(arrays: dict[str, np.ndarray]) -> None:
    arrays["version"] = np.array(2)


def _objects(arrays: dict[str, np.ndarray]) -> None:
    arrays["share"] = np.array([{}], dtype=object)


@pytest.mark.parametrize(
    ("alter", "complaint"),
    [
        (_one_less, "share: has shape"),
        (_more_beams, "ranges: has shape"),
        (_later, "version"),
        (_objects, "no key scans"),
    ],
)
def test_wrong_key_scans_are_refused(alter: Alter, complaint: str, tmp_path: Path) -> None:
    path, graph = written(tmp_path)
    with np.load(path) as file:
        arrays = dict(file)
    alter(arrays)
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=complaint):
        read_known_graph(path, graph)
