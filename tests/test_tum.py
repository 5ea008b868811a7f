"""TUM trajectories: written, read back, and compared with evo."""

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slam.errors import LogError
from slam.files.tum import format_tum, read_tum
from slam.pose import Pose2D, wrap_angle

DATA = Path(__file__).parents[1] / "../shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded logs in {DATA}")
one_directory = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
poses = st.builds(Pose2D, st.floats(-1e5, 1e5), st.floats(-1e5, 1e5), st.floats(-10, 10))


def test_a_line_is_written() -> None:
    line = format_tum(1234567890.5, Pose2D(1.0, -2.25, pi / 2))
    assert line == "1234567890.500000 1.000000 -2.250000 0.000000 0.000000000 0.000000000 0.707106781 0.707106781"


@one_directory
@given(st.lists(poses, min_size=1, max_size=20))
def test_a_written_trajectory_is_read_back(tmp_path: Path, trajectory: list[Pose2D]) -> None:
    times = [1.7e9 + 0.1 * i for i in range(len(trajectory))]
    path = tmp_path / "run.tum"
    path.write_text("".join(format_tum(t, pose) + "\n" for t, pose in zip(times, trajectory, strict=True)))
    stamps, table = read_tum(path)
    np.testing.assert_allclose(stamps, times, rtol=0, atol=1e-6)
    for row, pose in zip(table.tolist(), trajectory, strict=True):
        assert row[:2] == pytest.approx([pose.x, pose.y], abs=1e-6)
        assert abs(wrap_angle(row[2] - pose.theta)) < 1e-8


def test_comments_and_blank_lines_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "run.tum"
    path.write_text("# timestamp tx ty tz qx qy qz qw\n\n1 2 3 0 0 0 0 1\n  \n")
    stamps, table = read_tum(str(path))
    assert (stamps.tolist(), table.tolist()) == ([1.0], [[2.0, 3.0, 0.0]])


def test_the_motion_out_of_the_plane_is_dropped(tmp_path: Path) -> None:
    yaw, pitch = 2.0, 0.3
    q = (-sin(yaw / 2) * sin(pitch / 2), cos(yaw / 2) * sin(pitch / 2), sin(yaw / 2) * cos(pitch / 2))
    path = tmp_path / "run.tum"
    path.write_text(f"1 2 3 9 {q[0]} {q[1]} {q[2]} {cos(yaw / 2) * cos(pitch / 2)}\n")
    np.testing.assert_allclose(read_tum(path)[1], [[2.0, 3.0, yaw]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no pose in this file"),
        ("# nothing\n", "no pose in this file"),
        ("1 2 3 0 0 0 0 1\n2 2 3 0 0 0 1\n", "line 2: 7 numbers"),
        ("1 2 3 0 0 0 0 x\n", "line 1: not a number"),
        ("1 nan 3 0 0 0 0 1\n", "line 1: impossible value"),
        ("1 2 3 0 0 0 0 0\n", "line 1: qx qy qz qw are not a unit quaternion"),
        ("2 2 3 0 0 0 0 1\n1 2 3 0 0 0 0 1\n", "the stamps do not increase"),
        ("\0\x8b\xff", "line 1: not a number"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "run.tum"
    path.write_text(text)
    with pytest.raises(LogError, match=f"^{path}: {message}"):
        read_tum(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no such file"):
        read_tum(tmp_path / "absent")


@one_directory
@given(st.binary(max_size=100))
def test_random_bytes_are_an_error_of_one_line(tmp_path: Path, junk: bytes) -> None:
    path = tmp_path / "junk"
    path.write_bytes(junk)
    with pytest.raises(LogError) as caught:
        read_tum(path)
    assert "\n" not in str(caught.value)


def test_evo_reads_the_same_trajectory(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    trajectory = [Pose2D(*row) for row in random.uniform(-9, 9, (50, 3)).tolist()]
    path = tmp_path / "run.tum"
    path.write_text("\n".join(format_tum(100.0 + i / 8, pose) for i, pose in enumerate(trajectory)))
    assert_as_evo(path)


@needs_data
@pytest.mark.parametrize(
    "name", ["fr079.gt", "fr079.gt2", "aces.gt", "fr101.gt", "belgioioso.gt", "corridor_synthetic.gt"]
)
def test_the_references_read_as_evo_reads_them(name: str) -> None:
    assert_as_evo(DATA / f"{name}.tum")


def assert_as_evo(path: Path) -> None:
    """Stamps, positions and headings are those of evo's reader."""
    from evo.tools.file_interface import read_tum_trajectory_file

    stamps, table = read_tum(path)
    expected = read_tum_trajectory_file(str(path))
    np.testing.assert_array_equal(stamps, expected.timestamps)
    np.testing.assert_array_equal(table[:, :2], expected.positions_xyz[:, :2])
    turns = table[:, 2] - expected.get_orientations_euler("sxyz")[:, 2]
    np.testing.assert_allclose(np.sin(turns), 0.0, atol=1e-5)
    assert (np.cos(turns) > 0).all()
