"""Settings and fixtures of the whole test run."""

import fcntl
import os
import sys
from collections.abc import Callable, Generator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from slam.errors import RobotError
from slam.pose import FloatArray, Pose2D
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment
from slam.scan import LaserScan
from slam.scenario.file import load_scenario

# Keep bytecode on disk: otherwise every process that a test starts compiles all sources again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

settings.register_profile("hopslam", deadline=None, derandomize=True)  # time belongs in benchmarks
settings.load_profile("hopslam")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of ``make test-all``."""
    parser.addoption(
        "--all-faults",
        action="store_true",
        help="Run slow tests too: let every write fail, not only a few; kill commands.",
    )


NO_PYBULLET = f"no PyBullet: it has no wheel for CPython {sys.version_info.major}.{sys.version_info.minor}"


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Skip test files that import PyBullet where it is not installed."""
    report = yield
    if report.failed and _misses_pybullet(str(report.longrepr)):
        report.outcome, report.longrepr = "skipped", (report.nodeid, 1, f"Skipped: {NO_PYBULLET}")
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, None, None]:
    """Skip tests that start PyBullet where it is not installed."""
    try:
        yield
    except RobotError as error:
        if _misses_pybullet(str(error)):
            pytest.skip(NO_PYBULLET)
        raise


def _misses_pybullet(message: str) -> bool:
    return "PyBullet is not installed" in message and find_spec("pybullet") is None


@pytest.fixture
def small_log(tmp_path: Path) -> Path:
    """A recorded run in CARMEN's format: 12 scans, 5 cm apart, in a passage 4 m wide that ends 3 m ahead."""
    bearings = np.linspace(-np.pi / 2, np.pi / 2, 181)
    lines = []
    for k in range(12):
        with np.errstate(divide="ignore"):
            ranges = np.minimum((3.0 - 0.05 * k) / np.cos(bearings), 2.0 / np.abs(np.sin(bearings)))
        readings = " ".join(f"{reading:.3f}" for reading in ranges)
        pose = f"{0.05 * k:.3f} 0 0"
        lines.append(
            f"ROBOTLASER1 0 -1.570796 3.141593 0.017453 80 0.01 0 181 {readings} 0 {pose} {pose} 0 0 0 0 0 "
            f"{0.1 * k:.3f} host {0.1 * k:.3f}"
        )
    path = tmp_path / "small.log"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands draw no pictures at the end of a run, which takes longer than a short run."""
    monkeypatch.setattr(Experiment, "_draw", lambda *_: None)


Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]


@pytest.fixture(scope="session")
def scan_of() -> Scanner:
    """Makes a scan from a pose of the walls between corners, with noise of 1 cm; the stamp is 0.1 s times the seed."""

    def scan(corners: FloatArray, pose: Pose2D, seed: int = 0) -> LaserScan:
        bearings = np.linspace(-2.0, 2.0, 401)
        start, along = corners[:-1] - pose.translation, np.diff(corners, axis=0)
        d = np.stack([np.cos(bearings + pose.theta), np.sin(bearings + pose.theta)], axis=1)[:, None]
        cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
        with np.errstate(all="ignore"):  # a beam along a wall
            r = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
            t = (start[:, 0] * d[..., 1] - start[:, 1] * d[..., 0]) / cross
            r = np.where((r > 0) & (t >= 0) & (t <= 1), r, np.inf).min(axis=1)
        ranges = np.where(r < 8.0, r, np.inf) + 0.01 * np.random.default_rng(seed).normal(size=401)
        return LaserScan(0.1 * seed, -2.0, 0.01, 0.05, 8.0, ranges)

    return scan


@pytest.fixture(scope="session")
def room() -> FloatArray:
    """Corners of a room of 9 m by 5 m, one of which is cut out."""
    return np.array([[-3, -2], [4, -2], [4, 0], [6, 0], [6, 3], [-3, 3], [-3, -2]], float)


LAP = np.array([[0, 0], [10, 0], [10, 6], [0, 6]], float)
"""Corners of the way around a block, metres."""


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])


def _lap_path(laps: float, step: float = 0.12) -> list[Pose2D]:
    """Drive along the sides of LAP, and turn on the spot at its corners."""
    poses, left, side = [], laps * 32.0, 0
    while left > 0.0:
        start, end = LAP[side % 4], LAP[(side + 1) % 4]
        length, heading = float(np.hypot(*(end - start))), side * np.pi / 2
        way = np.arange(0.0, min(length, left), step)
        poses += [Pose2D.from_array(np.append(start + along / length * (end - start), heading)) for along in way]
        turns = np.linspace(0.0, np.pi / 2, 8)[:-1] if left > length else ()
        poses += [Pose2D.from_array(np.append(end, heading + turn)) for turn in turns]
        left, side = left - length, side + 1
    return poses


LAP_PATH = _lap_path(1.5)


@pytest.fixture(scope="session")
def lap_path() -> list[Pose2D]:
    """``T_map_base`` with each scan of ``lap_log``: one and a half times around a block."""
    return LAP_PATH


@pytest.fixture(scope="session")
def lap_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run in CARMEN's format along ``lap_path``. Its odometry is 2 % too long and turns to the left."""
    niches = [(4, -1, 4.6, -0.6), (10.5, 2, 11, 2.8), (6, 6.5, 7.2, 7), (-1, 3, -0.6, 4)]
    shapes = [_rectangle(-1, -1, 11, 7), _rectangle(1, 1, 9, 5), *(_rectangle(*niche) for niche in niches)]
    edges = np.concatenate([np.stack([shape[:-1], shape[1:]], axis=1) for shape in shapes])
    bearings, rng, lines = np.linspace(-np.pi / 2, np.pi / 2, 181), np.random.default_rng(1), []
    wheels = Pose2D()
    for k, pose in enumerate(LAP_PATH):
        motion = LAP_PATH[max(k - 1, 0)].between(pose)
        wheels = wheels @ Pose2D(1.02 * motion.x, motion.y, motion.theta + 0.02 * motion.x)
        ranges = _ranges(edges, pose, bearings) + 0.03 * rng.normal(size=181)
        readings = " ".join(f"{reading:.3f}" for reading in np.where(ranges < 4.0, ranges, 8.0))
        odometry, stamp = f"{wheels.x:.6f} {wheels.y:.6f} {wheels.theta:.9f}", f"{0.1 * k:.3f} host {0.1 * k:.3f}"
        scan = f"0 -1.570796 3.141593 0.017453 8 0.01 0 181 {readings} 0"
        lines.append(f"ROBOTLASER1 {scan} {odometry} {odometry} 0 0 0 0 0 {stamp}")
    log = tmp_path_factory.mktemp("lap") / "lap.log"
    log.write_text("\n".join(lines) + "\n")
    return log


def _ranges(edges: FloatArray, pose: Pose2D, bearings: FloatArray) -> FloatArray:
    """Metres to the nearest of the edges (E, 2, 2) along each bearing."""
    d = np.stack([np.cos(bearings + pose.theta), np.sin(bearings + pose.theta)], axis=1)[:, None]
    start, along = edges[:, 0] - pose.translation, edges[:, 1] - edges[:, 0]
    cross = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
    with np.errstate(all="ignore"):  # a beam along a wall
        r = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        t = (start[:, 0] * d[..., 1] - start[:, 1] * d[..., 0]) / cross
        return np.asarray(np.where((r > 0) & (t >= 0) & (t <= 1), r, np.inf).min(axis=1))


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all workers of this test run share."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@pytest.fixture(scope="session")
def lap_run(lap_log: Path, shared_folder: Path) -> Path:
    """The folder of a run whose loops were closed, made by the first worker that asks; copy it to change it."""
    folder = shared_folder / "closed"
    with (shared_folder / "closed.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "metrics.json").exists():
            replay_experiment(lap_log, load_scenario("replay")).run(folder)
    return folder
