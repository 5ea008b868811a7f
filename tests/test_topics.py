"""A run on topics: the published messages, their order, and the rules of ROS."""

from __future__ import annotations

import json
import re
from collections import Counter
from math import atan2, inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose
from PIL import Image
from rosbags.rosbag2 import Writer

from slam.assets import asset
from slam.files.ros.decoder import decode_transforms
from slam.files.ros.messages import RawMessage
from slam.pose import Pose2D
from slam.run.experiment import Outcome
from slam.run.experiment_setup import on_topics, replay_experiment, scenario_experiment
from slam.run.export.formats import export
from slam.run.results.run_record import RunRecord
from slam.run.topics.topic_session import TopicSession
from slam.run.topics.velocity_commands import SILENCE
from slam.scenario.file import load_scenario
from slam.topics import names
from slam.topics.topic import Topic
from tests.topic_bus import JAZZY, ListBus

SETTINGS = ["duration=4", "physics.engine=plan", "lidar.noise=none"]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Outcome, ListBus]:
    return published(tmp_path_factory.mktemp("run") / "run", SETTINGS)


def published(folder: Path, settings: list[str]) -> tuple[Outcome, ListBus]:
    bus = ListBus()
    with TopicSession([bus], pace=inf) as topics:
        experiment = scenario_experiment(load_scenario("corridor", settings))
        return on_topics(experiment, topics).run(folder, pictures=False), bus


def seconds(time: Any) -> float:
    return float(time.sec + 1e-9 * time.nanosec)


def test_all_topics_are_published(run: tuple[Outcome, ListBus]) -> None:
    outcome, bus = run
    counts, scans = Counter(heard.topic for heard in bus.sent), outcome.metrics["scans"]
    assert set(counts) == set(names.PUBLISHED)
    each = (names.CLOCK, names.TF, names.ODOM, names.SCAN, names.JOINT_STATES, names.SLAM_POSE)
    assert [counts[topic] for topic in each] == [scans] * len(each)
    assert counts[names.TF_STATIC] == counts[names.ROBOT_DESCRIPTION] == 1


def test_transforms_place_the_lidar_in_the_map_at_each_scan(run: tuple[Outcome, ListBus]) -> None:
    """REP 105: map -> odom -> base_link -> laser, each with one parent, all known when the scan comes."""
    outcome, bus = run
    record = RunRecord.open(outcome.folder)
    known: dict[tuple[float, str], tuple[str, Pose2D]] = {}
    mount: dict[str, tuple[str, Pose2D]] = {}
    found = []
    for heard in bus.sent:
        raw = RawMessage(heard.topic.name, heard.topic.type, "cdr", heard.data, 0)
        if heard.topic is names.TF_STATIC:
            mount |= {link.child: (link.frame, link.pose) for link in decode_transforms(raw)}
        elif heard.topic is names.TF:
            for link in decode_transforms(raw):
                assert (link.stamp, link.child) not in known
                known[link.stamp, link.child] = link.frame, link.pose
        elif heard.topic is names.SCAN:
            header = heard.message.header
            stamp, frame, pose = round(seconds(header.stamp), 9), header.frame_id, Pose2D()
            while frame != "map":
                frame, step = mount[frame] if frame in mount else known[stamp, frame]
                pose = step @ pose
            found.append(pose.as_array())
    expected = [(Pose2D.from_array(row) @ record.T_base_laser).as_array() for row in record.traces.estimate]
    assert_allclose(found, expected, atol=2e-6)  # trajectories are written to the micrometre


def test_stamps_never_decrease(run: tuple[Outcome, ListBus]) -> None:
    _, bus = run
    clock = 0.0
    for heard in bus.sent:
        if heard.topic is names.CLOCK:
            before, clock = clock, seconds(heard.message.clock)
            assert clock > before
        elif heard.topic in (names.TF, names.ODOM, names.SCAN, names.SLAM_POSE, names.JOINT_STATES):
            assert heard.stamp == pytest.approx(clock, abs=1e-9)


def test_the_pose_has_the_covariance_of_the_estimate(run: tuple[Outcome, ListBus]) -> None:
    outcome, bus = run
    steps = RunRecord.open(outcome.folder).traces.steps
    for heard, row in zip(bus.of(names.SLAM_POSE), steps, strict=True):
        message = heard.message
        assert message.header.frame_id == "map"
        C = message.pose.covariance.reshape(6, 6)
        assert_allclose(C, C.T)
        assert not C[2:5].any()
        entries = [C[0, 0], C[0, 1], C[0, 5], C[1, 1], C[1, 5], C[5, 5]]
        expected = [row[name] for name in ("cov_xx", "cov_xy", "cov_xth", "cov_yy", "cov_yth", "cov_thth")]
        assert_allclose(entries, expected, rtol=1e-6)


def test_the_wheels_roll_as_far_as_the_robot_drives(run: tuple[Outcome, ListBus]) -> None:
    _, bus = run
    joints = [heard.message for heard in bus.of(names.JOINT_STATES)]
    poses = [heard.message.pose.pose for heard in bus.of(names.ODOM)]
    way = np.hypot(poses[-1].position.x - poses[0].position.x, poses[-1].position.y - poses[0].position.y)
    assert joints[-1].name == ["left_wheel", "right_wheel"]
    assert way > 0.5
    assert joints[-1].position.mean() == pytest.approx(way / 0.0975, rel=0.01)
    assert joints[-1].velocity.mean() == pytest.approx(0.5 / 0.0975, rel=0.05)
    turned = 2.0 * atan2(poses[-1].orientation.z, poses[-1].orientation.w)
    assert np.diff(joints[-1].position)[0] == pytest.approx(turned * 0.33 / 0.0975, abs=0.05)


def test_the_description_names_the_published_joints(run: tuple[Outcome, ListBus]) -> None:
    _, bus = run
    urdf = bus.of(names.ROBOT_DESCRIPTION)[0].message.data
    assert '<joint name="left_wheel"' in urdf
    assert '<link name="base_link">' in urdf


def test_an_unknown_battery_is_nan(run: tuple[Outcome, ListBus]) -> None:
    _, bus = run
    message = bus.of(names.BATTERY_STATE)[0].message
    assert np.isnan([message.voltage, message.percentage, message.current]).all()
    assert not message.present


def test_the_last_map_is_the_exported_map(run: tuple[Outcome, ListBus], tmp_path: Path) -> None:
    outcome, bus = run
    export(RunRecord.open(outcome.folder), "ros", tmp_path / "map")
    message = bus.of(names.MAP)[-1].message
    header = yaml.safe_load((tmp_path / "map" / "map.yaml").read_text())
    origin, info = message.info.origin.position, message.info
    assert_allclose([origin.x, origin.y, 0.0], header["origin"], atol=1e-6)
    assert info.resolution == pytest.approx(header["resolution"])
    pixels = np.asarray(Image.open(tmp_path / "map" / "map.pgm"))[::-1]
    cells = message.data.reshape(info.height, info.width)
    for value, grey in ((-1, 205), (0, 254), (100, 0)):
        np.testing.assert_array_equal(cells == value, pixels == grey)
    assert (cells == 100).sum() > 100


def test_the_lines_are_the_walls_of_the_map(run: tuple[Outcome, ListBus]) -> None:
    outcome, bus = run
    (marker,) = bus.of(names.LINES)[-1].message.markers
    assert (marker.type, marker.action, marker.header.frame_id) == (5, 0, "map")
    points = np.array([(point.x, point.y) for point in marker.points]).reshape(-1, 2, 2)
    assert_allclose(points, RunRecord.open(outcome.folder).walls)


def test_dead_reckoning_publishes_no_map(tmp_path: Path) -> None:
    _, bus = published(tmp_path / "run", [*SETTINGS, "slam.mode=dead_reckoning"])
    assert not {heard.topic for heard in bus.sent} & {names.MAP, names.LINES, names.SLAM_POSE}
    children = [link.child_frame_id for heard in bus.of(names.TF) for link in heard.message.transforms]
    assert set(children) == {"base_link"}


def test_published_topics_replay_to_the_same_run(run: tuple[Outcome, ListBus], tmp_path: Path) -> None:
    outcome, bus = run
    with Writer(tmp_path / "bag", version=8) as writer:
        connections: dict[Topic, Any] = {}
        for heard in bus.sent:
            if heard.topic not in connections:
                connections[heard.topic] = writer.add_connection(heard.topic.name, heard.topic.type, typestore=JAZZY)
            writer.write(connections[heard.topic], round(1e9 * heard.stamp), heard.data)
    again = replay_experiment(tmp_path / "bag", load_scenario("corridor", SETTINGS)).run(
        tmp_path / "again", pictures=False
    )
    first, second = (RunRecord.open(folder).traces for folder in (outcome.folder, again.folder))
    assert_allclose(second.stamps, first.stamps, atol=1e-6)
    assert_allclose(second.estimate, first.estimate, atol=1e-3)


def test_the_layout_shows_existing_topics() -> None:
    layout = json.loads(asset("foxglove/layout.json").read_text())
    panels = layout["configById"]
    known = {topic.name for topic in names.PUBLISHED}
    shown = set(panels["3D!hopslam"]["topics"])
    plotted = {path["value"].split(".")[0] for panel in panels.values() for path in panel.get("paths", ())}
    assert shown | plotted <= known
    assert panels["3D!hopslam"]["publish"]["poseEstimateTopic"] == names.INITIAL_POSE.name
    drive = panels["Teleop!hopslam"]
    assert drive["topic"] == names.CMD_VEL.name
    assert 1.0 / drive["publishRate"] < SILENCE / 2.0
    assert set(re.findall(r"\w+!\w+", json.dumps(layout["layout"]))) == set(panels)
