"""Logs made harder: what each fault must do and must leave, and how the result is scored."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from slam.bench.stress.carried_poses import carried_poses
from slam.bench.stress.mending import mended
from slam.bench.stress.report import VARIANTS, stress_tables, usual_variants
from slam.bench.stress.variant import Variant
from slam.bench.stress.wheel_faults import motions
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.logs import Log, read_log
from slam.files.tum import format_tum, read_tum
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D, stack_poses
from slam.run.scoring.pose_errors import read_relations, relation_errors_of

DATA = Path(__file__).parents[1] / "../shared/data"
SCRIPT = Path(__file__).parents[1] / "../shared/tools/stress.py"
COUNT, BEAMS = 400, 19


@pytest.fixture
def log() -> Log:
    """Curves of 10 cm a scan, with ranges of 1 to 5 m."""
    random = np.random.default_rng(0)
    poses = [Pose2D()]
    for turn in 0.05 * np.sin(np.arange(COUNT - 1) / 10.0):
        poses.append(poses[-1] @ Pose2D(0.1, 0.0, float(turn)))
    return Log(
        lidar=Lidar(-np.pi / 2, np.pi / 18, BEAMS, 0.0, 8.0, 0.2),
        T_base_laser=Pose2D(),
        stamps=0.2 * np.arange(COUNT),
        ranges=np.where(random.random((COUNT, BEAMS)) < 0.1, np.inf, random.uniform(1.0, 5.0, (COUNT, BEAMS))),
        T_odom_base=stack_poses(poses),
        time_increment=0.001,
        skipped={},
        ignored={},
        report="",
    )


def spoilt(log: Log, text: str, seed: int = 1) -> Log:
    return Variant.parse(text).spoilt(log, seed)


@pytest.mark.parametrize("text", VARIANTS)
def test_a_variant_is_what_its_text_says(text: str) -> None:
    assert str(Variant.parse(text)) == text


@pytest.mark.parametrize(
    "text", ["", "none", "every", "every=x", "every=1.5", "blind=-1", "coarse=inf", "every=2,mend"]
)
def test_no_variant(text: str) -> None:
    with pytest.raises(InputError, match="need NAME=NUMBER"):
        Variant.parse(text)


def test_only_a_log_without_backward_motions_is_mended() -> None:
    assert any(variant.mend for variant in usual_variants("fr079"))
    others = usual_variants("aces")
    assert not any(variant.mend for variant in others)
    assert len(set(others)) == len(others)


@pytest.mark.parametrize(
    "fault", ["noise=0.1", "scatter=0.4", "jitter=0.02", "scale=0.02", "slips=9", "blind=9", "stale=0.3"]
)
def test_what_is_drawn_is_drawn_again_with_the_same_seed(log: Log, fault: str) -> None:
    assert Variant.parse(fault).random
    once, again, other = spoilt(log, fault), spoilt(log, fault), spoilt(log, fault, seed=2)
    np.testing.assert_array_equal(once.ranges, again.ranges)
    np.testing.assert_array_equal(once.T_odom_base, again.T_odom_base)
    assert (once.ranges != other.ranges).any() or (once.T_odom_base != other.T_odom_base).any()


def test_fewer_scans_and_beams(log: Log) -> None:
    thin = spoilt(log, "every=5,beams=3")
    np.testing.assert_array_equal(thin.stamps, log.stamps[::5])
    np.testing.assert_array_equal(thin.T_odom_base, log.T_odom_base[::5])
    np.testing.assert_array_equal(thin.ranges, log.ranges[::5, ::3])
    np.testing.assert_allclose(thin.lidar.angles, log.lidar.angles[::3])
    assert thin.lidar.scan_time == pytest.approx(1.0)
    assert thin.time_increment == pytest.approx(0.003)


def test_ranges_keep_to_their_bounds_and_missing_echoes_stay_missing(log: Log) -> None:
    echo = np.isfinite(log.ranges)
    for fault, most in (("coarse=0.2", 0.1), ("noise=0.05", 0.3), ("scatter=0.4", 5.0)):
        made = spoilt(log, fault)
        np.testing.assert_array_equal(np.isfinite(made.ranges), echo)
        assert 0.0 < np.abs(made.ranges[echo] - log.ranges[echo]).max() <= most
        np.testing.assert_array_equal(made.T_odom_base, log.T_odom_base)


def test_thin_things_stand_before_the_wall_in_18_of_40_metres(log: Log) -> None:
    made = spoilt(log, "scatter=0.4")
    hit = (made.ranges != log.ranges).any(axis=1)
    assert hit.mean() == pytest.approx(18.0 / 40.0, abs=0.05)
    changed = made.ranges != log.ranges
    assert changed[hit].mean() == pytest.approx(0.9 * 0.4, abs=0.05)
    assert (made.ranges[changed] < log.ranges[changed] - 0.1 + 1e-9).all()
    assert made.ranges[changed].min() >= 0.4


def test_the_wheels_faults_are_where_and_as_many_as_asked(log: Log) -> None:
    true = motions(log.T_odom_base)
    blind = motions(spoilt(log, "blind=10").T_odom_base)
    changed = np.abs(blind - true).max(axis=1) > 1e-9
    assert changed.sum() == 10
    np.testing.assert_allclose(blind[changed], 0.0, atol=1e-9)
    slips = motions(spoilt(log, "slips=10").T_odom_base) - true
    jumps = slips[np.abs(slips[:, 2]) > 1e-9, 2]
    np.testing.assert_allclose(np.degrees(np.abs(jumps)), np.full(10, 10.0))
    stale = spoilt(log, "stale=0.3").T_odom_base
    late = np.flatnonzero(np.abs(stale - log.T_odom_base).max(axis=1) > 1e-9)
    assert len(late) == pytest.approx(0.2 * COUNT, rel=0.3)  # 0.3 times 0.7: after a late one comes one on time
    assert np.diff(late).min() > 1
    np.testing.assert_allclose(stale[late], log.T_odom_base[late - 1])


def test_a_scale_is_of_all_ways_and_a_jitter_of_all_places(log: Log) -> None:
    true, scaled = motions(log.T_odom_base), motions(spoilt(log, "scale=0.02").T_odom_base)
    np.testing.assert_allclose(scaled[:, :2], 1.02 * true[:, :2], atol=1e-12)
    turning = np.abs(true[:, 2]) > 1e-6
    assert set(np.round(scaled[turning, 2] / true[turning, 2], 6)) == {0.98, 1.02}
    moved = spoilt(log, "jitter=0.02").T_odom_base - log.T_odom_base
    assert np.std(moved[:, :2] - moved[:, :2].mean(axis=0)) == pytest.approx(0.02, rel=0.1)
    np.testing.assert_allclose(moved[:, 2], 0.0, atol=1e-12)


def test_more_faults_than_a_short_log_has_room_for(log: Log) -> None:
    short = spoilt(log, "every=40,blind=50,slips=50")
    assert len(short) == 10


def backwards(log: Log) -> FloatArray:
    """The log's way with its scans 100 to 150 driven backwards."""
    poses = [Pose2D()]
    for number, move in enumerate(motions(log.T_odom_base)):
        poses.append(poses[-1] @ Pose2D(float(move[0]) * (-1.0 if 100 <= number < 150 else 1.0), 0.0, float(move[2])))
    return stack_poses(poses)


def test_backward_motions_get_their_sign_back(log: Log) -> None:
    truth = backwards(log)
    found = mended(log, log.stamps, truth).T_odom_base
    wrong = np.abs(motions(found) - motions(truth)).max(axis=1) > 1e-6
    assert np.flatnonzero(wrong).tolist() in ([], [99], [150], [99, 150])  # three steps are looked at: the ends blur
    again = mended(mended(log, log.stamps, truth), log.stamps, truth)
    np.testing.assert_allclose(again.T_odom_base, found, atol=1e-12)


def test_an_estimate_that_is_right_at_its_scans_is_right_between_them(log: Log) -> None:
    turned = Pose2D(2.0, 1.0, 0.7)
    moved = stack_poses(turned @ Pose2D.from_array(pose) for pose in log.T_odom_base)
    at = carried_poses(log.stamps, log.stamps[::7], moved[::7], log.stamps, log.T_odom_base)
    np.testing.assert_allclose(at.poses[at.known], moved[at.known], atol=1e-9)
    assert at.known.tolist() == (log.stamps <= log.stamps[::7][-1]).tolist()


def test_tables_of_a_small_log(small_log: Path) -> None:
    truth = "\n".join(format_tum(0.1 * k, Pose2D(0.05 * k, 0.0, 0.0)) for k in range(12))
    small_log.with_name("small.gt.tum").write_text(truth + "\n")
    wanted = ["every=2", "stale=0.3"]
    (table,) = stress_tables([str(small_log)], wanted, 3, Path(), SlamConfig(), Terminal(quiet=True))
    assert [row[:2] for row in table.rows] == [("every=2", "1"), ("stale=0.3", "3")]
    assert {len(row) for row in table.rows} == {len(table.columns)}
    assert all(float(row[2]) < 0.01 for row in table.rows)
    assert table.rows[0][7] == "6"


@pytest.fixture
def script() -> ModuleType:
    if not SCRIPT.is_file() or not (DATA / "fr101.log.gz").is_file():
        pytest.skip(f"no {SCRIPT} or no logs")
    spec = importlib.util.spec_from_file_location("stress", SCRIPT)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it leaves its files open
@pytest.mark.parametrize(
    "text",
    ["mend,every=3", "every=2,beams=2,coarse=0.05", "jitter=0.02,slips=5,every=2,blind=5", "scatter=0.4"],
)
def test_the_shared_script_makes_the_same_log(script: ModuleType, text: str, tmp_path: Path) -> None:
    """To what its text keeps of a number: micrometres of a pose, millimetres of a range."""
    path, reference = DATA / "fr101.log.gz", DATA / "fr101.gt.tum"
    variant, log = Variant.parse(text), read_log(path)
    mine = variant.spoilt(variant.unspoilt(log, *read_tum(reference)), 1)
    words = [f"mend={reference}" if word == "mend" else word for word in text.split(",")]
    script.make(str(path), str(tmp_path / "made.log.gz"), words)
    theirs = read_log(tmp_path / "made.log.gz")
    np.testing.assert_allclose(mine.T_odom_base, theirs.T_odom_base, atol=1e-5)
    np.testing.assert_allclose(mine.ranges, theirs.ranges, atol=6e-4)
    np.testing.assert_allclose(mine.stamps, theirs.stamps)
    assert mine.lidar.angle_increment == pytest.approx(theirs.lidar.angle_increment)


def test_the_shared_script_scores_the_same(script: ModuleType) -> None:
    log, relations = read_log(DATA / "fr079.log.gz"), DATA / "fr079.relations.gz"
    stamps = log.stamps[::5]
    poses = log.T_odom_base[::5] + np.random.default_rng(0).normal(0.0, 0.1, (len(stamps), 3))
    known = read_relations(relations)
    first, second = (carried_poses(known[:, k], stamps, poses, log.stamps, log.T_odom_base) for k in (0, 1))
    theirs = script.score(stamps, poses, (log.stamps, log.T_odom_base), str(relations))
    assert np.mean(relation_errors_of(known, first, second).metres) == pytest.approx(theirs["mean"], abs=1e-9)
