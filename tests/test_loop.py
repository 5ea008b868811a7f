"""The loop with a scripted robot and a scripted method."""

import signal
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from slam.errors import RobotError, RobotTimeout
from slam.lidars import Lidar
from slam.line_slam import Estimate
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.loop import run_loop
from slam.run.pilots import ReplayPilot, WaypointPilot
from slam.run.robot_env import RobotEnv
from slam.run.step import Step
from slam.run.watchers import Interruption
from slam.scan import LaserScan
from slam.scenario.schema import Route

LIDAR = Lidar(-0.5, 0.5, 3, 0.1, 9.0, 0.1)
ROUTE = Route(waypoints=((2.0, 0.0),))
TRUTH, WRONG = Pose2D(0.1, 0.2, 0.3), Pose2D(-7.0, 5.0, 1.0)


class Scripted:
    """A robot that sees what it is told, and notes the commands."""

    T_base_laser = Pose2D()

    def __init__(self, truths: Sequence[Pose2D], collides_at: int | None = None) -> None:
        self._truths, self._collides_at = truths, collides_at
        self._index = 0
        self.commands: list[Twist2D] = []

    def __enter__(self) -> "Scripted":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def observe(self, timeout: float = 1.0) -> Observation | None:
        index, self._index = self._index, self._index + 1
        if index >= len(self._truths):
            return None
        scan = LaserScan(0.1 * index, LIDAR.angle_min, LIDAR.angle_increment, 0.1, 9.0, np.ones(3))
        return Observation(scan, Odometry(scan.stamp, Pose2D()), self._truths[index], index == self._collides_at)

    def drive(self, command: Twist2D) -> Twist2D:
        self.commands.append(command)
        return Twist2D(command.linear / 2, command.angular)


class Oracle:
    """A method that believes what it is told."""

    def __init__(self, beliefs: Sequence[Pose2D]) -> None:
        self._beliefs = iter(beliefs)

    def update(self, scan: LaserScan, odometry: Odometry) -> Estimate:
        return Estimate(scan.stamp, next(self._beliefs))


class Notes:
    """A watcher that records the steps, and a pilot that records the poses that it gets."""

    progress = 0.25

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self.poses: list[Pose2D] = []

    def on_step(self, step: Step) -> None:
        self.steps.append(step)

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D:
        self.poses.append(T_map_base)
        return Twist2D(0.5, -0.25)


def env_of(robot: Scripted) -> RobotEnv:
    return RobotEnv(lambda seed: robot, LIDAR, Twist2D(1.0, 1.0))


def test_the_pilot_sees_the_estimate_and_never_the_truth() -> None:
    beliefs, notes = [Pose2D(-k, 3.0 * k, 0.1) for k in range(4)], Notes()
    assert run_loop(env_of(Scripted([TRUTH] * 4)), Oracle(beliefs), notes, [], 0) == "no more scans"
    assert notes.poses == beliefs


@pytest.mark.parametrize(
    ("truth", "belief", "ending", "drives"),
    [(Pose2D(-5.0), Pose2D(2.0), "arrived", 0), (Pose2D(2.0), Pose2D(-5.0), "no more scans", 3)],
)
def test_the_pilot_reaches_the_goal_by_its_estimate(truth: Pose2D, belief: Pose2D, ending: str, drives: int) -> None:
    robot = Scripted([truth] * 3)
    assert run_loop(env_of(robot), Oracle([belief] * 3), WaypointPilot(ROUTE, Pose2D()), [], 0) == ending
    assert len(robot.commands) == drives


@pytest.mark.parametrize(("duration", "ending"), [(0.45, "duration over"), (9.0, "no more scans")])
def test_a_run_ends_with_the_duration_or_with_the_scans(duration: float, ending: str) -> None:
    robot = Scripted([TRUTH] * 4)
    assert run_loop(env_of(robot), Oracle([WRONG] * 4), ReplayPilot(4), [], 0, duration=duration) == ending


class Stamped(Scripted):
    """A robot whose scans have these stamps."""

    def __init__(self, stamps: Sequence[float]) -> None:
        super().__init__([TRUTH] * len(stamps))
        self._stamps = iter(stamps)

    def observe(self, timeout: float = 1.0) -> Observation | None:
        observation = super().observe(timeout)
        if observation is None:
            return None
        scan = replace(observation.scan, stamp=next(self._stamps))
        return replace(observation, scan=scan, odometry=replace(observation.odometry, stamp=scan.stamp))


def test_scans_with_non_increasing_stamps_are_left_out() -> None:
    notes = Notes()
    run_loop(env_of(Stamped([0.0, 0.1, 0.1, 0.05, 0.2])), Oracle([WRONG] * 5), ReplayPilot(4), [notes], 0)
    assert [step.estimate.stamp for step in notes.steps] == [0.0, 0.1, 0.2]
    with pytest.raises(RobotError, match="not later than 1"):
        run_loop(env_of(Stamped([1.0] * 60)), Oracle([WRONG]), ReplayPilot(4), [], 0)


@pytest.mark.parametrize("at", [0, 2])
def test_a_collision_ends_the_run_after_its_scan(at: int) -> None:
    robot, notes = Scripted([TRUTH] * 6, collides_at=at), Notes()
    assert run_loop(env_of(robot), Oracle([WRONG] * 6), ReplayPilot(6), [notes], 0) == "collided"
    assert [step.observation.collided for step in notes.steps] == [False] * at + [True]
    assert len(robot.commands) == at


def test_a_collision_at_the_goal_is_a_collision() -> None:
    robot = Scripted([TRUTH], collides_at=0)
    assert run_loop(env_of(robot), Oracle([Pose2D(2.0)]), WaypointPilot(ROUTE, Pose2D()), [], 0) == "collided"


def test_every_observer_gets_every_step() -> None:
    pilot, watchers = Notes(), [Notes(), Notes()]
    run_loop(env_of(Scripted([TRUTH] * 3)), Oracle([WRONG] * 3), pilot, watchers, 0)
    for notes in watchers:
        assert [step.index for step in notes.steps] == [0, 1, 2]
        assert [step.applied for step in notes.steps] == [Twist2D(), *[Twist2D(0.25, -0.25)] * 2]
        assert {step.progress for step in notes.steps} == {0.25}
        assert {step.estimate.T_map_base for step in notes.steps} == {WRONG}
        assert {step.observation.T_map_base for step in notes.steps} == {TRUTH}


def test_ctrl_c_ends_the_run_after_its_step() -> None:
    class Pressed(Scripted):
        def observe(self, timeout: float = 1.0) -> Observation | None:
            if self._index == 2:
                signal.raise_signal(signal.SIGINT)
            return super().observe(timeout)

    before = signal.getsignal(signal.SIGINT)
    notes = Notes()
    with Interruption() as interruption, pytest.raises(KeyboardInterrupt):
        run_loop(env_of(Pressed([TRUTH] * 9)), Oracle([TRUTH] * 9), ReplayPilot(9), [notes, interruption], 0)
    assert [step.index for step in notes.steps] == [0, 1, 2]
    assert signal.getsignal(signal.SIGINT) == before


class Silent(Scripted):
    """A robot whose lidar is away for some calls, after its first scan."""

    def __init__(self, calls: int) -> None:
        super().__init__([TRUTH] * 4)
        self._away = calls

    def observe(self, timeout: float = 1.0) -> Observation | None:
        if self._index and self._away:
            self._away -= 1
            raise RobotTimeout("no scan")
        return super().observe(timeout)


def test_a_silent_robot_is_stopped_and_waited_for() -> None:
    robot, pilot = Silent(2), Notes()
    assert run_loop(env_of(robot), Oracle([WRONG] * 4), pilot, [], 0, patience=600.0) == "no more scans"
    forward = Twist2D(0.5, -0.25)
    assert robot.commands == [forward, Twist2D(), Twist2D(), forward, forward, forward]
    with pytest.raises(RobotTimeout, match="no scan"):
        run_loop(env_of(Silent(1)), Oracle([WRONG] * 4), pilot, [], 0)
    with pytest.raises(RobotTimeout, match="no scan"):
        run_loop(env_of(Silent(9)), Oracle([WRONG] * 4), pilot, [], 0, patience=600.0, told_to_end=lambda: True)
