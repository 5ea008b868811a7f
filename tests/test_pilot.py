"""Following waypoints."""

from itertools import pairwise
from math import pi

import pytest

from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.pilots import ReplayPilot, WaypointPilot
from slam.scenario.schema import Route

ROUTE = Route(waypoints=((2.0, 0.0), (2.0, 2.0)), speed=0.5, turn_speed=0.8, arrival=0.1)


def test_the_pilot_drives_straight_at_full_speed() -> None:
    assert WaypointPilot(ROUTE, Pose2D()).command(Pose2D()) == Twist2D(0.5, 0.0)


def test_the_pilot_turns_on_the_spot_first() -> None:
    assert WaypointPilot(ROUTE, Pose2D()).command(Pose2D(0.0, 0.0, pi / 2)) == Twist2D(0.0, -0.8)


def test_the_pilot_drives_the_whole_route() -> None:
    pilot, pose = WaypointPilot(ROUTE, Pose2D()), Pose2D()
    progress = [pilot.progress]
    for _ in range(400):
        command = pilot.command(pose)
        progress.append(pilot.progress)
        if command is None:
            break
        pose = pose @ Pose2D(0.1 * command.linear, 0.0, 0.1 * command.angular)
    assert command is None
    assert pose.distance(Pose2D(2.0, 2.0)) <= 0.1
    assert progress[0] == 0.0
    assert progress[-1] == 1.0
    assert all(b > a - 0.02 for a, b in pairwise(progress))


def test_without_waypoints_the_pilot_stands() -> None:
    pilot = WaypointPilot(Route(), Pose2D())
    assert pilot.command(Pose2D()) == Twist2D()
    assert pilot.progress == 0.0


def test_a_passenger_counts_scans() -> None:
    passenger = ReplayPilot(4)
    assert [passenger.command(Pose2D()) for _ in range(2)] == [Twist2D()] * 2
    assert passenger.progress == pytest.approx(0.5)
