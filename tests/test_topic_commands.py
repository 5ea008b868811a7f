"""Messages received on topics: velocities, an initial pose, and garbage."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from math import inf
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

import slam.run.topics.velocity_commands as velocity_commands
from hardware.emulator.emulator import EmulatorState
from hardware.emulator.topics import EmulatorTopics
from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError, RobotTimeout
from slam.files.fields import BadLine
from slam.files.ros.from_json import cdr_of_json
from slam.files.ros.live_encoder import LiveEncoder
from slam.line_localizer import LineLocalizer
from slam.mapping.surfel_map import SurfelMap
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.run import launch
from slam.run.experiment_setup import on_topics, replay_experiment, scenario_experiment
from slam.run.loop import step_patiently
from slam.run.pilots import Wanderer
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import Traces
from slam.run.topics.paced_robot import PacedRobot
from slam.run.topics.topic_choice import TopicChoice, parse_address
from slam.run.topics.topic_session import TopicSession
from slam.run.topics.velocity_commands import CommandedPilot, VelocityCommands
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.topics import names
from slam.topics.topic import Topic
from tests.rooms import room_scenario
from tests.topic_bus import ListBus

JAZZY = get_typestore(Stores.ROS2_JAZZY)
SCAN = LaserScan(0.0, -1.0, 0.1, 0.06, 4.0, np.full(21, 1.5))
REACH = st.floats(-1e6, 1e6)


def cdr(topic: Topic, linear: float, angular: float) -> bytes:
    """Encode a command as a ROS node sends it, by rosbags and its newest types."""
    make = JAZZY.types
    vector = make["geometry_msgs/msg/Vector3"]
    twist = make["geometry_msgs/msg/Twist"](vector(linear, 0.0, 0.0), vector(0.0, 0.0, angular))
    if topic is names.STAMPED_CMD_VEL:
        header = make["std_msgs/msg/Header"](make["builtin_interfaces/msg/Time"](3, 4), "base_link")
        return bytes(JAZZY.serialize_cdr(make[topic.type](header, twist), topic.type))
    return bytes(JAZZY.serialize_cdr(twist, topic.type))


@given(linear=REACH, angular=REACH, topic=st.sampled_from([names.CMD_VEL, names.STAMPED_CMD_VEL]))
def test_a_command_is_received_as_it_was_sent(linear: float, angular: float, topic: Topic) -> None:
    commands = VelocityCommands()
    commands.hear(topic, cdr(topic, linear, angular))
    assert commands.twist == Twist2D(linear, angular)


@given(data=st.binary(max_size=200), topic=st.sampled_from([names.CMD_VEL, names.STAMPED_CMD_VEL]))
def test_no_bytes_raise_or_give_an_infinite_speed(data: bytes, topic: Topic) -> None:
    commands = VelocityCommands()
    commands.hear(topic, data)
    assert commands.count + commands.garbage == 1
    assert np.isfinite([commands.twist.linear, commands.twist.angular]).all()


@pytest.mark.parametrize("wrong", [inf, -inf, np.nan, 1e300])
def test_garbage_does_not_change_the_last_command(wrong: float) -> None:
    commands = VelocityCommands()
    commands.hear(names.CMD_VEL, cdr(names.CMD_VEL, 0.5, 0.0))
    commands.hear(names.CMD_VEL, cdr(names.CMD_VEL, wrong, 0.0))
    commands.hear(names.CMD_VEL, cdr(names.CMD_VEL, 0.0, wrong))
    assert (commands.twist, commands.count, commands.garbage) == (Twist2D(0.5), 1, 2)


def test_the_robot_stops_half_a_second_after_a_command(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(velocity_commands, "monotonic", lambda: now[0])
    commands = VelocityCommands()
    commands.hear(names.CMD_VEL, cdr(names.CMD_VEL, 0.5, 0.0))
    now[0] += 0.49
    assert commands.twist == Twist2D(0.5)
    now[0] += 0.02
    assert commands.twist == Twist2D()


def test_the_first_command_replaces_the_pilot(monkeypatch: pytest.MonkeyPatch) -> None:
    commands = VelocityCommands()
    pilot = CommandedPilot(commands, Wanderer())
    assert pilot.command(Pose2D(), SCAN).linear > 0.0
    commands.hear(names.CMD_VEL, cdr(names.CMD_VEL, -0.2, 0.1))
    assert pilot.command(Pose2D(), SCAN) == Twist2D(-0.2, 0.1)
    monkeypatch.setattr(velocity_commands, "SILENCE", 0.0)
    assert pilot.command(Pose2D(), SCAN) == Twist2D()


def test_a_simulated_robot_keeps_its_limits(tmp_path: Path) -> None:
    bus = ListBus()
    with TopicSession([bus], pace=inf) as topics:
        experiment = scenario_experiment(load_scenario("corridor", ["duration=1", "physics.engine=plan"]))
        experiment = on_topics(experiment, topics)
        bus.say(names.CMD_VEL, cdr(names.CMD_VEL, 1e6, -1e6))
        run = experiment.run(tmp_path / "run", pictures=False)
    steps = RunRecord.open(run.folder).traces.steps
    assert set(steps["v"][1:].tolist()) <= {1.2, 0.0}  # 0 where the machine took longer than half a second
    assert set(steps["omega"][1:].tolist()) <= {-5.236, 0.0}


def test_a_replay_ignores_commands(tmp_path: Path) -> None:
    made = scenario_experiment(load_scenario("corridor", ["duration=1", "physics.engine=plan"]))
    folder = made.run(tmp_path / "run", pictures=False).folder
    bus = ListBus()
    with TopicSession([bus], pace=inf) as topics:
        on_topics(replay_experiment(folder, load_scenario("corridor")), topics)
    assert bus.listeners == []


def test_an_initial_pose_is_used_by_a_localizer() -> None:
    slam, bus = LineLocalizer(SlamConfig(), Pose2D(), SurfelMap(SlamConfig().map)), ListBus()
    given = Pose2D(3.0, -2.0, 1.25)
    with TopicSession([bus]) as topics:
        topics.hear_initial_pose(slam)
        bus.say(names.INITIAL_POSE, b"garbage")
        assert slam.update(SCAN, Odometry(0.0, Pose2D())).lost
        bus.say(names.INITIAL_POSE, LiveEncoder().unsure_pose(0.0, given, None))
        estimate = slam.update(SCAN, Odometry(0.1, Pose2D(0.3, 0.0, 0.0)))
    assert not estimate.lost
    np.testing.assert_allclose(estimate.T_map_base.as_array(), given.as_array(), atol=1e-12)


@given(st.recursive(st.none() | st.floats() | st.text(max_size=3), lambda inner: st.dictionaries(
    st.sampled_from(["linear", "angular", "x", "z", "header", "twist", "stamp"]), inner, max_size=3)))  # fmt: skip
def test_json_is_a_message_or_refused(value: Any) -> None:
    for topic in (names.CMD_VEL, names.STAMPED_CMD_VEL, names.INITIAL_POSE):
        try:
            data = cdr_of_json(json.dumps(value).encode(), topic.type)
        except BadLine:
            continue
        JAZZY.deserialize_cdr(data, topic.type)


def test_json_fills_a_message() -> None:
    given = {"header": {"frame_id": "map"}, "pose": {"pose": {"position": {"x": 2}, "orientation": {"w": 1.0}}}}
    message: Any = JAZZY.deserialize_cdr(cdr_of_json(json.dumps(given).encode(), names.INITIAL_POSE.type),
                                         names.INITIAL_POSE.type)  # fmt: skip
    assert (message.header.frame_id, message.pose.pose.position.x, message.pose.pose.orientation.w) == ("map", 2.0, 1.0)
    assert message.pose.covariance.shape == (36,)
    short = given | {"pose": {"covariance": [1.0, 2.0]}}
    with pytest.raises(BadLine):
        cdr_of_json(json.dumps(short).encode(), names.INITIAL_POSE.type)


def test_the_pace_option_sets_the_time_between_scans(monkeypatch: pytest.MonkeyPatch) -> None:
    now, published = [50.0], list[Any]()

    def sleep(seconds: float) -> None:
        now[0] += seconds

    monkeypatch.setattr("slam.run.topics.paced_robot.monotonic", lambda: now[0])
    monkeypatch.setattr("slam.run.topics.paced_robot.sleep", sleep)
    experiment = scenario_experiment(load_scenario("corridor", ["physics.engine=plan"]))
    env = experiment.env.wrapped(lambda robot: PacedRobot(robot, 4.0, published.append))
    _, info = env.reset(seed=0)
    began, first = now[0], info["observation"].scan.stamp
    for _ in range(8):
        info = env.step(np.zeros(2, np.float32))[-1]
    env.close()
    passed = info["observation"].scan.stamp - first
    assert passed == pytest.approx(0.8)
    assert now[0] - began == pytest.approx(passed / 4.0, abs=1e-6)
    assert published == sorted(published)
    assert first < published[0] < published[-1] < info["observation"].scan.stamp


@pytest.mark.parametrize(
    ("given", "address"),
    [(True, ("127.0.0.1", 8765)), (9000, ("127.0.0.1", 9000)), ("9001", ("127.0.0.1", 9001)),
     ("0.0.0.0:9002", ("0.0.0.0", 9002)), ("[::1]:9003", ("::1", 9003))],
)  # fmt: skip
def test_foxglove_is_local_by_default(given: bool | int | str, address: tuple[str, int]) -> None:
    assert parse_address(given) == address


@pytest.mark.parametrize("given", ["", "here", "1:x", "99999", "-1"])
def test_an_invalid_address_is_reported(given: str) -> None:
    with pytest.raises(InputError, match="give PORT or HOST:PORT"):
        parse_address(given)


@pytest.mark.parametrize(
    ("choice", "words"),
    [(TopicChoice(pace=2.0), "add --ros or --foxglove"), (TopicChoice(foxglove=True, pace=-1.0), "does not run back")],
)
def test_an_invalid_pace_is_reported(choice: TopicChoice, words: str) -> None:
    with pytest.raises(InputError, match=words), choice.session(Terminal(quiet=True)):
        pass


class Controller(ListBus):
    """Answers each scan with one command, and takes its time."""

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        super().publish(topic, stamp, message)
        if topic is names.SCAN:
            sleep(0.001 * (len(self.sent) % 7))
            self.say(names.CMD_VEL, cdr(names.CMD_VEL, 0.3, float(np.sin(10.0 * stamp))))


def stepped(folder: Path) -> Traces:
    with TopicSession([Controller()], pace=0.0) as topics:
        experiment = scenario_experiment(load_scenario("corridor", ["duration=2", "physics.engine=plan"]))
        return RunRecord.open(on_topics(experiment, topics).run(folder, pictures=False).folder).traces


def test_a_stepped_run_takes_one_command_per_scan(tmp_path: Path) -> None:
    first, again = stepped(tmp_path / "first"), stepped(tmp_path / "again")
    np.testing.assert_allclose(first.steps["omega"][1:], np.sin(10.0 * first.stamps[:-1]), atol=1e-5)
    np.testing.assert_array_equal(first.truth, again.truth)
    np.testing.assert_array_equal(first.estimate, again.estimate)


def test_a_stepped_run_without_commands_times_out() -> None:
    with TopicSession([ListBus()], pace=0.0) as topics:
        experiment = on_topics(scenario_experiment(load_scenario("corridor", ["physics.engine=plan"])), topics)
        env, asked = experiment.env, iter([False, False, True])
        env.reset(seed=0)
        with pytest.raises(RobotTimeout, match="no command on /cmd_vel"):
            step_patiently(lambda twist: env.step(np.zeros(2, np.float32)), Twist2D(), inf, lambda: next(asked))
        env.close()


def test_a_replay_is_not_stepped(tmp_path: Path) -> None:
    made = scenario_experiment(load_scenario("corridor", ["duration=1", "physics.engine=plan"]))
    folder = made.run(tmp_path / "run", pictures=False).folder
    with TopicSession([ListBus()], pace=0.0) as topics, pytest.raises(InputError, match="hears no commands"):
        on_topics(replay_experiment(folder, load_scenario("corridor")), topics)


def test_a_real_robot_has_no_pace_option() -> None:
    experiment = scenario_experiment(load_scenario("corridor", ["physics.engine=plan"]))
    real = replace(experiment, notes={"backend": "hardware"})
    with TopicSession([ListBus()], pace=2.0) as topics, pytest.raises(InputError, match="at its own pace"):
        on_topics(real, topics)
    with TopicSession([ListBus()]) as topics:
        assert on_topics(real, topics).env is real.env


def test_a_robot_that_publishes_itself_is_not_published_again() -> None:
    with pytest.raises(InputError, match="leave out --ros"):
        launch.run("corridor", backend="ros", ros=True)


def test_the_emulated_robot_is_published() -> None:
    bus, scenario = ListBus(), room_scenario((-2.0, 3.0), (-2.0, 2.0))
    bearings = np.arange(-3, 4) * 0.5
    with TopicSession([bus]) as topics:
        published = EmulatorTopics(topics, scenario)
        for k in (0, 1, 1):
            at, ranges = Pose2D(0.05 * k, 0.0, 0.0), np.array([np.nan, 1.0, 1.5, 3.0, 1.5, 9.0, np.nan])
            published.show(EmulatorState(0.1 * k, at, at, np.empty((0, 2)), False, bearings, ranges, 12.5))
    scans, odometry = ([heard.message for heard in bus.of(topic)] for topic in (names.SCAN, names.ODOM))
    assert len(scans) == len(odometry) == 2  # a repeated state is published once
    assert scans[1].ranges[3] == 3.0
    assert np.isposinf(scans[1].ranges[5])
    assert scans[1].angle_min + 3 * scans[1].angle_increment == pytest.approx(0.0, abs=1e-6)
    assert odometry[1].twist.twist.linear.x == pytest.approx(0.5)
    assert bus.of(names.BATTERY_STATE)[0].message.voltage == 12.5
    assert struct.unpack("<4xii", bus.of(names.CLOCK)[1].data) == (0, 100_000_000)
