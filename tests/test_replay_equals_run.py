"""The replay of a recorded run gives the files of the run, byte by byte."""

from pathlib import Path

import pytest

import hopslam

FILES = ("trajectory.tum", "odometry.tum", "closed.tum", "map.json", "graph.json", "lines.geojson", "walls.geojson")
THIRD = 0.3333333333333333  # more digits than a log has
PLACED = (
    "robot.start.x=1.0",
    f"robot.start.theta={THIRD}",
    f"lidar.mount.theta={THIRD}",
    f"lidar.mount.y={0.1 * THIRD}",
)


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("corridor", ("lidar.model=table1", "robot.traction.slip=0.05")),
        ("crowded_corridor", PLACED),
        ("office_loop", ("lidar.model=ld19", "lidar.noise=realistic")),
    ],
)
def test_a_replay_equals_its_run(tmp_path: Path, scenario: str, settings: tuple[str, ...]) -> None:
    first, again = tmp_path / "first", tmp_path / "again"
    hopslam.run(scenario, settings=["physics.engine=plan", "duration=4", *settings], out=first, pictures=False)
    hopslam.replay(first, out=again, pictures=False)
    assert [name for name in FILES if (first / name).read_bytes() != (again / name).read_bytes()] == []
