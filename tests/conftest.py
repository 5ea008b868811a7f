"""Settings and fixtures of the whole test run."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

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
