"""Harder variants of logs: the laws of each variant, and the logs of the independent shared script."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from slam.bench.stress.odometry_steps import chained, steps, with_signs
from slam.bench.stress.variants import VARIATIONS, made_harder, with_chance
from slam.cli.main import app
from slam.errors import InputError
from slam.files.logs import Log, read_log
from slam.lidars import Lidar
from slam.pose import FloatArray, Pose2D, compose_poses, relative_poses
from slam.run.scoring.pose_errors import Trajectory, carried_poses, errors_between, poses_at, read_relations

SHARED = Path(__file__).parents[1] / "../shared"
SCRIPT = SHARED / "tools/stress.py"
VALUES = {
    "every": 3, "beams": 2, "jitter": 0.05, "scale": 0.02, "slips": 4, "blind": 3, "stale": 0.3, "coarse": 0.05,
    "noise": 0.01, "scatter": 0.4,
}  # fmt: skip


def wheels(count: int, seed: int = 0) -> FloatArray:
    random = np.random.default_rng(seed)
    return chained(
        np.zeros(3),
        np.column_stack([random.normal([0.3, 0.0], 0.02, (count - 1, 2)), random.normal(0.0, 0.1, count - 1)]),
    )


def log_of(scans: int = 60, beams: int = 30) -> Log:
    ranges = np.random.default_rng(1).uniform(1.0, 6.0, (scans, beams))
    ranges[:, 4] = np.inf
    return Log(
        Lidar(-1.5, 0.1, beams, 0.1, 9.0, 0.1), Pose2D(0.1), 0.5 * np.arange(scans), ranges, wheels(scans), 0.001,
        skipped={}, ignored={}, report="by hand",
    )  # fmt: skip


@pytest.mark.parametrize("name", VARIATIONS)
def test_a_seed_makes_one_log_and_keeps_the_input(name: str) -> None:
    log, before = log_of(), log_of()
    once, again, other = (made_harder(log, f"{name}={VALUES[name]}", seed) for seed in (1, 1, 2))
    assert np.array_equal(log.ranges, before.ranges)
    assert np.array_equal(log.T_odom_base, before.T_odom_base)
    assert np.array_equal(once.ranges, again.ranges)
    assert np.array_equal(once.T_odom_base, again.T_odom_base)
    same = np.array_equal(once.ranges, other.ranges) and np.array_equal(once.T_odom_base, other.T_odom_base)
    assert same == (name in ("every", "beams", "coarse"))
    assert not (np.array_equal(once.ranges, log.ranges) and np.array_equal(once.T_odom_base, log.T_odom_base))
    assert np.isinf(once.ranges).sum() == len(once)  # a beam without an echo stays without


def test_each_variation_has_its_effect() -> None:
    log = log_of()
    assert made_harder(log, "", 1) is log
    fewer = made_harder(log, "every=7,beams=4", 1)
    assert np.array_equal(fewer.ranges, log.ranges[::7, ::4])
    assert np.array_equal(fewer.stamps, log.stamps[::7])
    assert np.allclose(fewer.lidar.angles, log.lidar.angles[::4])
    assert fewer.time_increment == 0.004
    missed = steps(made_harder(log, "blind=3", 1).T_odom_base)
    assert (np.abs(missed).max(axis=1) < 1e-12).sum() == 3
    late = made_harder(log, "stale=0.3", 1).T_odom_base
    held = np.flatnonzero((late != log.T_odom_base).any(axis=1))
    assert len(held) > 5
    assert np.array_equal(late[held], log.T_odom_base[held - 1])
    assert (np.diff(held) > 1).all()
    longer = steps(made_harder(log, "scale=0.02", 1).T_odom_base)
    assert np.allclose(longer[:, :2], 1.02 * steps(log.T_odom_base)[:, :2])
    assert np.allclose(np.abs(np.abs(longer[:, 2] / steps(log.T_odom_base)[:, 2]) - 1.0), 0.02)
    cluttered = made_harder(log, "scatter=0.4", 1).ranges
    assert (cluttered <= log.ranges).all()
    assert 0.2 < (cluttered < log.ranges)[:, 0].mean() < 0.5
    assert np.allclose(made_harder(log, "coarse=0.25", 1).ranges[:, :4] % 0.25, 0.0)


def test_a_slip_turns_all_later_poses() -> None:
    slipped = steps(made_harder(log_of(), "slips=4", 1).T_odom_base) - steps(log_of().T_odom_base)
    assert np.allclose(np.sort(np.abs(np.degrees(slipped[:, 2])))[-5:], [0.0, 10.0, 10.0, 10.0, 10.0])


def test_missing_minus_signs_are_restored() -> None:
    true = steps(wheels(60))
    true[20:30, 0] *= -1.0
    recorded = true.copy()
    recorded[20:30, :2] *= -1.0
    reference = Trajectory(0.5 * np.arange(60), chained(np.zeros(3), true))
    found = steps(with_signs(reference.stamps, chained(np.zeros(3), recorded), reference))
    inside = np.r_[0:18, 22:28, 32:59]  # a mean over three steps mixes both signs where these change
    assert np.allclose(found[inside], true[inside])


@pytest.mark.parametrize("variant", ["tilt=3", "every", "every=0", "noise=-1", "beams=two", "blind=inf"])
def test_an_unknown_variant_is_named(variant: str) -> None:
    with pytest.raises(InputError, match="need NAME=NUMBER with one of every, beams, jitter"):
        made_harder(log_of(), f"beams=2,{variant}", 1)


@pytest.mark.parametrize("variant", ["every=31", "beams=11", "slips=55", "blind=12", "every=10,slips=1"])
def test_a_variant_that_needs_a_longer_log_is_named(variant: str) -> None:
    with pytest.raises(InputError, match=r"is too much for (60|6) scans of 30 beams; [0-9]+ is the most"):
        made_harder(log_of(), variant, 1)


def test_the_random_variant_is_added_if_missing() -> None:
    assert with_chance("") == "noise=0.002"
    assert with_chance("every=5,beams=2") == "noise=0.002,every=5,beams=2"
    assert with_chance("every=5,blind=2") == "every=5,blind=2"


def test_poses_are_propagated_by_odometry() -> None:
    stamps, odometry = 0.5 * np.arange(60), wheels(60)
    true = compose_poses(np.array([3.0, -1.0, 0.7]), odometry)
    times = np.array([-1.0, 0.2, 7.3, 29.0, 31.0])
    found = carried_poses(times, Trajectory(stamps[::10], true[::10]), Trajectory(stamps, odometry))
    assert found.known.tolist() == [False, True, True, False, False]  # the last pose that is kept is at 25 s
    between = poses_at(times[1:3], stamps, true).poses
    assert np.abs(relative_poses(between, found.poses[1:3])).max() < 0.01


def shared_script() -> Any:
    spec = importlib.util.spec_from_file_location("stress_script", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


needs_script = pytest.mark.skipif(not SCRIPT.is_file(), reason=f"no {SCRIPT}")


@needs_script
@pytest.mark.parametrize("variant", ["every=3", "beams=2", "coarse=0.05", "beams=3,every=2"])
def test_the_shared_script_makes_the_same_log(variant: str, tmp_path: Path) -> None:
    source, target = SHARED / "data/fr101.log.gz", tmp_path / "theirs.log.gz"
    shared_script().make(str(source), str(target), variant.split(","))
    theirs, ours = read_log(target), made_harder(read_log(source), variant, 1)
    assert np.allclose(theirs.stamps, ours.stamps)
    assert np.allclose(theirs.lidar.angles, ours.lidar.angles, atol=1e-5)
    assert np.allclose(theirs.ranges, ours.ranges, atol=1e-3, equal_nan=True)
    assert np.allclose(theirs.T_odom_base, ours.T_odom_base, atol=2e-6)


@needs_script
@pytest.mark.parametrize("variant", ["scale=0.02", "slips=20", "blind=10", "stale=0.3", "scatter=0.4"])
def test_the_shared_script_changes_as_much(variant: str, tmp_path: Path) -> None:
    source, target = SHARED / "data/fr101.log.gz", tmp_path / "theirs.log.gz"
    shared_script().make(str(source), str(target), [variant])
    log, theirs = read_log(source), read_log(target)
    ours = made_harder(log, variant, 1)
    changed = [
        (
            (np.abs(steps(made.T_odom_base) - steps(log.T_odom_base)) > 1e-4).any(axis=1).mean(),
            (np.asarray(made.ranges) < np.asarray(log.ranges) - 2e-3).mean(),
        )
        for made in (theirs, ours)
    ]
    assert np.allclose(changed[0], changed[1], rtol=0.15, atol=0.002)


@needs_script
def test_the_shared_script_scores_the_same(tmp_path: Path) -> None:
    script, source = shared_script(), SHARED / "data/fr079.log.gz"
    log, full = script.Log(str(source)), read_log(source)
    thinned = made_harder(full, "every=20", 1)
    estimate = Trajectory(thinned.stamps, thinned.T_odom_base + np.array([0.3, 0.2, 0.1]))
    order = np.argsort(log.stamp, kind="stable")
    path = SHARED / "data/fr079.relations.gz"
    theirs = script.score(*estimate, (log.stamp[order], log.odom[order]), str(path))
    relations, odometry = read_relations(path), Trajectory(full.stamps, full.T_odom_base)
    first, second = (carried_poses(relations[:, column], estimate, odometry) for column in (0, 1))
    errors = errors_between(relations, first, second)
    assert len(errors.metres) == theirs["used"]
    assert np.mean(errors.metres) == pytest.approx(theirs["mean"], rel=1e-3)


@pytest.mark.skipif(not SHARED.is_dir(), reason=f"no {SHARED}")
def test_the_bench_has_one_row_per_variant() -> None:
    arguments = [
        "bench",
        "slam",
        "fr101",
        "--stress",
        "--variant",
        "every=8",
        "--seeds",
        "1",
        "--data",
        str(SHARED / "data"),
    ]
    shown = CliRunner().invoke(app, arguments)
    assert shown.exit_code == 0
    assert "fr101  every=8" in shown.output.replace(" " * 2, "  ")


def test_a_variant_needs_stress() -> None:
    shown = CliRunner().invoke(app, ["bench", "slam", "--variant", "every=5"])
    assert isinstance(shown.exception, InputError)
    assert "needs --stress" in str(shown.exception)
