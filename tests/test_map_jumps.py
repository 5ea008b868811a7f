"""The map jumps when a loop is closed: the pilot drives on smoothly, and the log follows REP 105."""

from collections.abc import Iterator
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from slam.files.ros.decoder import decode_transforms
from slam.files.ros.messages import TF
from slam.odometry import Twist2D
from slam.pose import Pose2D, stack_poses
from slam.run.pilots import WaypointPilot
from slam.run.results.run_log import logged_messages
from slam.run.results.run_record import RunRecord
from slam.scenario.schema import Route

ROUTE = Route(waypoints=((3.0, 0.0), (3.0, 3.0), (0.0, 3.0)), speed=0.5, turn_speed=0.8, arrival=0.1)
PERIOD, JUMP = 0.1, 0.5


class Driven(NamedTuple):
    """Number of steps, path length, and turn until the pilot said that it had arrived, and the pose of the robot."""

    steps: int
    path_length: float
    turned: float
    end: Pose2D
    fastest: float


def drive(direction: float, turn: float, at: int, max_steps: int = 1200) -> Driven:
    """Drive on an estimate that is off by JUMP metres in ``direction`` and by ``turn`` until step ``at``."""
    off = Pose2D(JUMP * cos(direction), JUMP * sin(direction), turn)
    pilot, pose = WaypointPilot(ROUTE, Pose2D()), Pose2D()
    length = turned = fastest = 0.0
    for step in range(max_steps):
        command: Twist2D | None = pilot.command(pose if step >= at else off @ pose)
        if command is None:
            return Driven(step, length, turned, pose, fastest)
        length, turned = length + PERIOD * command.linear, turned + PERIOD * abs(command.angular)
        fastest = max(fastest, abs(command.angular))
        pose = pose @ Pose2D(PERIOD * command.linear, 0.0, PERIOD * command.angular)
    raise AssertionError(f"did not arrive after a jump towards {direction:.2f} in step {at}")


WITHOUT = drive(0.0, 0.0, 0)


@pytest.mark.parametrize("turn", [0.0, 0.1, -0.1])
@pytest.mark.parametrize("direction", np.linspace(-pi, pi, 8, endpoint=False))
def test_a_jump_of_the_map_does_not_jerk_the_robot(direction: float, turn: float) -> None:
    """The map jumps once, at any moment of the drive. The robot still arrives and keeps its limit of turning speed. It
    turns by at most one turn more than without the jump, and its path is longer by at most twice the jump."""
    for at in range(1, 220, 7):
        driven = drive(direction, turn, at)
        if driven.steps < at:
            continue  # it arrived before
        assert driven.end.distance(Pose2D(0.0, 3.0)) <= ROUTE.arrival + 1e-9
        assert driven.fastest <= ROUTE.turn_speed
        assert driven.turned < WITHOUT.turned + 2 * pi + 0.5, at
        assert driven.path_length < WITHOUT.path_length + 2 * JUMP + 0.5, at


def transforms(folder: Path) -> Iterator[tuple[Pose2D, Pose2D]]:
    """T_odom_base and T_map_odom, scan by scan."""
    for message in logged_messages(folder / "log.mcap"):
        if message.topic == TF:
            T_odom_base, T_map_odom = decode_transforms(message)
            yield T_odom_base.pose, T_map_odom.pose


def test_only_map_to_odom_jumps_never_odometry(lap_run: Path) -> None:
    record = RunRecord.open(lap_run)
    poses = list(transforms(lap_run))
    assert len(poses) == len(record.traces.stamps)
    odometry = stack_poses(T_odom_base for T_odom_base, _ in poses)
    np.testing.assert_allclose(odometry, record.traces.odometry, atol=2e-6)
    in_map = stack_poses(T_map_odom @ T_odom_base for T_odom_base, T_map_odom in poses)
    np.testing.assert_allclose(in_map, record.traces.estimate, atol=2e-6)
    steps = np.hypot(*np.diff(odometry, axis=0)[:, :2].T)
    assert steps.max() < 0.13
    assert record.traces.local is not None
    local = [Pose2D.from_array(pose) for pose in record.traces.local]
    T_map_local = [a @ b.inverse() for a, b in zip(map(Pose2D.from_array, in_map), local, strict=True)]
    moved = np.array(
        [(a @ here).distance(b @ here) for (a, b), here in zip(pairwise(T_map_local), local[1:], strict=True)]
    )
    closed = record.traces.steps["closure"][1:] >= 0
    assert moved[~closed].max() < 0.1  # by the corrections of matches
    assert (moved[closed] > 1e-4).all()
