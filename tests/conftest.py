"""Settings and fixtures of the whole test run."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

settings.register_profile("hopslam", deadline=None, derandomize=True)  # time belongs in benchmarks
settings.load_profile("hopslam")


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


Scanner = Callable[[FloatArray, Pose2D, int], LaserScan]


@pytest.fixture(scope="session")
def scan_of() -> Scanner:
    """Makes a noisy scan, 1 cm, of the walls between these corners from a pose; the stamp is 0.1 s times the seed."""

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
