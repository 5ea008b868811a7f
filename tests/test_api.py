"""The API gives the results of the method, refuses bad input, and continues saved maps."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hopslam
from slam.config import SlamConfig
from slam.errors import BackEndLost
from slam.files.logs import read_log
from slam.line_slam import LineSlam
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]
MOUNT = (0.1, 0.05, 0.3)
PNG = b"\x89PNG\r\n"


def path(count: int, step: float = 0.05) -> list[Pose2D]:
    """Drive through the room at 0.5 m/s and up to 0.3 rad/s."""
    poses = [Pose2D(-1.5, -0.5, 0.2)]
    for k in range(count - 1):
        poses.append(poses[-1] @ Pose2D(step, 0.0, 0.6 * step * np.cos(0.1 * k)))
    return poses


@pytest.fixture(scope="module")
def drive(scan_of: Scanner, room: FloatArray) -> list[tuple[Pose2D, LaserScan]]:
    """The robot in the room and its scan, with the lidar at MOUNT."""
    return [(pose, scan_of(room, pose @ Pose2D(*MOUNT), k)) for k, pose in enumerate(path(70))]


@pytest.fixture(scope="module")
def finished(drive: list[tuple[Pose2D, LaserScan]]) -> hopslam.Map:
    slam = hopslam.Slam(T_base_laser=MOUNT, start=drive[0][0], range_max=8.0)
    for pose, scan in drive:
        slam.update(scan.ranges, scan.bearings, (pose.x, pose.y, pose.theta), scan.stamp)
    return slam.finish()


def test_the_api_gives_the_result_of_the_method(drive: list[tuple[Pose2D, LaserScan]]) -> None:
    method = LineSlam(SlamConfig(), Pose2D(*MOUNT), drive[0][0])
    slam = hopslam.Slam(T_base_laser=MOUNT, start=drive[0][0], range_min=0.05, range_max=8.0)
    for pose, scan in drive[:30]:
        expected = method.update(scan, Odometry(scan.stamp, pose))
        found = slam.update(scan.ranges, scan.bearings, pose, scan.stamp)
        assert found.pose.distance(expected.T_map_base) < 1e-9
        assert found.stamp == expected.stamp
        assert found.segments is not None
        assert len(found.segments) == len(expected.segments or ())
    assert np.allclose(slam.walls, method.lines.ends, atol=1e-6)


@pytest.mark.parametrize("every", [1, 3])
def test_scans_alone_give_the_motion(drive: list[tuple[Pose2D, LaserScan]], every: int) -> None:
    slam = hopslam.Slam(T_base_laser=MOUNT, start=drive[0][0])
    for pose, scan in drive[::every]:
        estimate = slam.update(scan.ranges, scan.bearings)
        assert estimate.pose.distance(pose) < 0.03
        assert abs(estimate.pose.theta - pose.theta) < 0.01
        assert not estimate.lost


def test_scans_far_apart_use_their_stamps(scan_of: Scanner, room: FloatArray) -> None:
    """Two metres and a radian from one scan to the next, 2.5 s later: half a metre a second, as robots drive."""
    turns = 0.85 * np.arange(14)
    poses = [
        Pose2D(1.5 + 2.0 * np.cos(a), 0.5 + 0.9 * np.sin(a), a + np.pi / 2 + 0.2 * np.sin(a / 0.85)) for a in turns
    ]
    slam = hopslam.Slam(start=poses[0])
    for k, pose in enumerate(poses):
        scan = scan_of(room, pose, k)
        assert slam.update(scan.ranges, scan.bearings, stamp=2.5 * k).pose.distance(pose) < 0.01


def test_a_rejected_scan_changes_nothing(drive: list[tuple[Pose2D, LaserScan]]) -> None:
    clean, troubled = hopslam.Slam(), hopslam.Slam()
    for pose, scan in drive[:10]:
        clean.update(scan.ranges, scan.bearings, pose, scan.stamp)
        good = {"ranges": scan.ranges, "angles": scan.bearings, "odometry": pose, "stamp": scan.stamp}
        for bad in ({"ranges": [None] * 401}, {"stamp": np.nan}, {"odometry": (0.0, np.nan, 0.0)}):
            with pytest.raises(hopslam.InputError):
                troubled.update(**good | bad)
        troubled.update(scan.ranges, scan.bearings, pose, scan.stamp)
    assert clean.pose == troubled.pose
    assert np.array_equal(clean.walls, troubled.walls)


def test_the_finished_map_is_the_room(finished: hopslam.Map, drive: list[tuple[Pose2D, LaserScan]]) -> None:
    true = np.array([(pose.x, pose.y) for pose, _ in drive])
    assert np.hypot(*(finished.trajectory[:, :2] - true).T).max() < 0.02
    assert finished.pose == Pose2D.from_array(finished.trajectory[-1])
    assert finished.stamps.tolist() == [scan.stamp for _, scan in drive]
    ends = finished.walls.reshape(-1, 2)
    assert ((np.abs(ends - [1.5, 0.5]) - [4.5, 2.5]).max(axis=1) < 0.05).all()  # of 9 m by 5 m around (1.5, 0.5)


def test_a_finished_slam_refuses_scans(drive: list[tuple[Pose2D, LaserScan]]) -> None:
    slam, scan = hopslam.Slam(), drive[0][1]
    with pytest.raises(hopslam.InputError, match="before the first scan"):
        slam.finish()
    slam.update(scan.ranges, scan.bearings)
    assert slam.finish() is slam.finish() is slam.map
    with pytest.raises(hopslam.InputError, match="saved_map"):
        slam.update(scan.ranges, scan.bearings)


def test_a_failed_closing_keeps_the_current_map(
    drive: list[tuple[Pose2D, LaserScan]], monkeypatch: pytest.MonkeyPatch
) -> None:
    slam = hopslam.Slam()
    for _, scan in drive[:5]:
        slam.update(scan.ranges, scan.bearings)
    known = slam.map

    def fail(error: BaseException) -> Callable[[object], None]:
        def finish(_: object) -> None:
            raise error

        return finish

    monkeypatch.setattr("slam.run.closing_loops.finish", fail(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        slam.finish()
    monkeypatch.setattr("slam.run.closing_loops.finish", fail(BackEndLost("the process was killed")))
    with pytest.warns(UserWarning, match="was killed; the run is not closed"):
        assert np.array_equal(slam.finish().trajectory, known.trajectory)


def test_a_map_is_a_snapshot(drive: list[tuple[Pose2D, LaserScan]], tmp_path: Path) -> None:
    slam = hopslam.Slam()
    for _, scan in drive[:5]:
        slam.update(scan.ranges, scan.bearings)
    early = slam.map
    first = early.save(tmp_path / "one").read_text()
    for _, scan in drive[5:20]:
        slam.update(scan.ranges, scan.bearings)
    assert early.save(tmp_path / "two").read_text() == first
    assert len(slam.map.trajectory) == 20
    assert len(early.trajectory) == 5


def test_a_saved_map_is_loaded_and_continued(
    finished: hopslam.Map, drive: list[tuple[Pose2D, LaserScan]], tmp_path: Path
) -> None:
    assert finished.save(tmp_path / "room") == tmp_path / "room/map.json"
    loaded = hopslam.load_map(tmp_path / "room")
    assert np.array_equal(loaded.walls, finished.walls)
    assert loaded.pose.distance(finished.pose) < 0.05
    for given in (loaded, finished, tmp_path / "room", str(tmp_path / "room/map.json")):
        slam = hopslam.Slam(T_base_laser=MOUNT, saved_map=given, start=drive[10][0])
        for pose, scan in drive[10:20]:
            slam.update(scan.ranges, scan.bearings)
            assert slam.pose.distance(pose) < 0.03
    assert np.array_equal(loaded.walls, hopslam.load_map(tmp_path / "room").walls)
    assert slam.finish().saved is not None


@pytest.mark.parametrize(
    ("settings", "message"),
    [("slam.mode=paper", r"needs slam\.mode=hopslam"), ("slam.map.cell=0.1", r"slam\.map\.cell=0\.2")],
)
def test_settings_that_contradict_the_map_are_named(
    finished: hopslam.Map, settings: str, message: str, tmp_path: Path
) -> None:
    finished.save(tmp_path)
    for given in (finished, tmp_path):
        for user in (
            lambda g=given: hopslam.Slam(settings, saved_map=g),
            lambda g=given: hopslam.Localizer(g, settings),
        ):
            with pytest.raises(hopslam.InputError, match=message):
                user()


def test_loops_are_closed_as_a_replay_closes_them(lap_log: Path, lap_run: Path, tmp_path: Path) -> None:
    """Poses and walls of a lap with wheel errors are the same, and a saved map keeps its key scans and its graph."""
    log, run = read_log(lap_log), hopslam.Run.open(lap_run)
    slam = hopslam.Slam(T_base_laser=log.T_base_laser, range_min=0.0, range_max=log.lidar.range_max)
    closures = sum(
        slam.update(log.ranges[k], log.lidar.angles, log.T_odom_base[k], log.stamps[k]).loop_closed
        for k in range(len(log))
    )
    lap = slam.finish()
    assert closures == run.metrics["closures"] > 0
    assert np.allclose(lap.trajectory, run.trajectory, atol=1e-3)
    assert np.allclose(lap.walls, run.walls, atol=1e-3)
    lap.save(tmp_path / "lap")
    hopslam.load_map(tmp_path / "lap").save(tmp_path / "again")
    known = [hopslam.load_map(tmp_path / folder).saved.graph for folder in ("lap", "again")]
    assert len(known[0].keys) == len(known[1].keys) > 0
    assert np.array_equal(known[0].graph.nodes, known[1].graph.nodes)


def test_a_robot_localizes_itself_in_a_map(finished: hopslam.Map, drive: list[tuple[Pose2D, LaserScan]]) -> None:
    lost = hopslam.Localizer(finished, T_base_laser=MOUNT)
    known = hopslam.Localizer(finished, T_base_laser=MOUNT, start=drive[10][0])
    assert known.sure
    assert not lost.sure
    for pose, scan in drive[10:45]:
        distances_off = []
        for localizer in (lost, known):
            localizer.update(hopslam.Scan(scan.ranges, scan.bearings))
            distances_off.append(localizer.pose.distance(pose))
    assert lost.sure
    assert known.sure
    assert max(distances_off) < 0.03


def test_paper_mode_maps_but_cannot_be_saved(drive: list[tuple[Pose2D, LaserScan]], tmp_path: Path) -> None:
    slam = hopslam.Slam("slam.mode=paper", range_max=8.0)
    for pose, scan in drive[:3]:
        assert slam.update(scan.ranges, scan.bearings, pose).covariance is None
    assert len(slam.finish().walls)
    with pytest.raises(hopslam.InputError, match=r"slam\.mode=hopslam"):
        slam.save(tmp_path / "paper")


@pytest.mark.parametrize("order", [1, -1], ids=["counter-clockwise", "clockwise"])
def test_a_scan_is_deskewed_in_both_directions_of_rotation(room: FloatArray, order: int) -> None:
    """The robot stands in the first scan; in all others it turns on the spot while beam after beam is taken."""
    between, bearings, turn = 0.05 / 400, np.linspace(-2.0, 2.0, 401)[::order], 1.0
    slam = hopslam.Slam(time_increment=between)
    for k in range(8):
        headings = 0.1 * k * turn + (turn * between * np.arange(401) if k else 0.0) + bearings
        estimate = slam.update(distances(room, (0.5, 0.5), headings), bearings, (0.5, 0.5, 0.1 * k * turn), 0.1 * k)
    # the stamp is the time of the first beam counter-clockwise; a clockwise turn takes that beam last
    assert estimate.stamp == pytest.approx(0.7 if order == 1 else 0.75)
    assert estimate.pose.theta == pytest.approx(turn * estimate.stamp, abs=1e-3)


def distances(room: FloatArray, place: tuple[float, float], headings: FloatArray) -> FloatArray:
    """Metres from the place to the nearest wall in each direction, (N,)."""
    d = np.stack([np.cos(headings), np.sin(headings)], axis=1)[:, None]
    start, along = room[:-1] - place, np.diff(room, axis=0)
    cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
    with np.errstate(divide="ignore"):  # a beam along a wall
        r = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        t = (start[:, 0] * d[..., 1] - start[:, 1] * d[..., 0]) / cross
    return np.where((r > 0) & (t >= 0) & (t <= 1), r, np.inf).min(axis=1)


def test_every_object_has_a_picture(finished: hopslam.Map, drive: list[tuple[Pose2D, LaserScan]]) -> None:
    scan = hopslam.Scan(drive[0][1].ranges, drive[0][1].bearings)
    slam = hopslam.Slam()
    assert slam._repr_png_() is None
    slam.update(scan)
    for value in (scan, scan.segments(), finished, slam):
        assert (value._repr_png_() or b"").startswith(PNG)


def test_segments_move_with_the_sensor(drive: list[tuple[Pose2D, LaserScan]]) -> None:
    pose = Pose2D(1.0, -2.0, 0.7)
    here = hopslam.Scan(drive[0][1].ranges, drive[0][1].bearings).segments()
    there = here.moved(pose)
    assert np.allclose(there.ends, pose.transform(here.ends.reshape(-1, 2)).reshape(-1, 2, 2))
    assert np.allclose(there.lengths, here.lengths)


def test_the_import_is_light_and_the_names_are_there() -> None:
    program = (
        "import sys, hopslam; heavy = {'numpy', 'numba', 'pydantic', 'matplotlib'} & set(sys.modules); "
        "assert not heavy, heavy; from hopslam import *; assert set(hopslam.__all__) <= set(globals()); "
        "assert set(hopslam.__all__) <= set(dir(hopslam)); assert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
