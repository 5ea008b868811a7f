"""Tests of hopslam on ROS topics, against the rclpy of two distributions of ROS 2: ``make test-ros``.

They need 600 MB of wheels. The file is not named ``test_``, so that pytest finds it only by its path.
"""

import json
import os
import signal
import site
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.testing import assert_allclose
from rosbags.typesys import Stores, get_typestore

from slam.files.ros.mcap_files import mcap_messages
from slam.files.tum import read_tum
from slam.topics import names
from slam.topics.ros_bus import open_ros_bus

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "slam" / "bench" / "ros_client.py"
PYTHONS = [Path(path) for path in os.environ["ROS_PYTHONS"].split(":")]
JAZZY = get_typestore(Stores.ROS2_JAZZY)
PLAN = ["--set", "physics.engine=plan"]
BLIND = ["--set", "slam.mode=dead_reckoning"]
"""A robot that publishes no map, nor the transform to one: for the SLAM of another program."""


@pytest.fixture(params=PYTHONS, ids=lambda path: path.parents[1].name)
def client(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The Python of a distribution, in a domain of its own."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(20 + os.getpid() % 80))
    return Path(request.param)


class Program:
    """A program and its output; it ends with the block."""

    def __init__(self, *words: object) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(list(map(str, words)), stdin=pipe, stdout=pipe, text=True, cwd=ROOT)

    def __enter__(self) -> "Program":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def output(self, timeout: float = 120.0) -> str:
        return self.process.communicate(timeout=timeout)[0]


class RosNode(Program):
    """``ros_client.py`` in the Python of a ROS distribution; the constructor waits until it is ready."""

    def __init__(self, python: Path, *words: object) -> None:
        super().__init__(python, CLIENT, *words)
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"

    def result(self) -> Any:
        return json.loads(self.output().splitlines()[-1])


def hopslam(*words: object) -> Program:
    return Program(sys.executable, "-c", "from slam.cli.main import main; main()", *words)


def run_robot(folder: Path, duration: float, *words: str) -> Program:
    return hopslam("run", "corridor", "--ros", *PLAN, "--set", f"duration={duration}", "--out", folder, *words)


def wait_for(path: Path, lines: int) -> None:
    """Wait until a file has this number of lines."""
    until = time.monotonic() + 30.0
    while not (path.is_file() and len(path.read_text().splitlines()) >= lines):
        assert time.monotonic() < until, path
        time.sleep(0.1)


def test_no_scan_is_lost_and_none_is_late(client: Path, tmp_path: Path) -> None:
    with RosNode(client, "listen", 90) as node, run_robot(tmp_path / "run", 15.0) as robot:
        robot.output()
        heard = node.result()
    stamps, _ = read_tum(tmp_path / "run" / "trajectory.tum")
    assert len(heard["stamps"]) > len(stamps) - 20  # the first second may pass before the client is found
    assert_allclose(heard["stamps"], stamps[-len(heard["stamps"]) :], atol=1e-6)
    assert np.median(heard["ages"]) < 5e-3
    with hopslam("export", tmp_path / "run", "--to", "ros", "--out", tmp_path / "map") as export:
        export.output()
    assert_is_map(heard["map"], tmp_path / "map")


def assert_is_map(heard: dict[str, Any], folder: Path) -> None:
    """Check that the grid equals the files to which the run is exported."""
    import yaml
    from PIL import Image

    description = yaml.safe_load((folder / "map.yaml").read_text())
    assert (heard["x"], heard["y"]) == pytest.approx(description["origin"][:2], abs=1e-6)
    assert heard["resolution"] == pytest.approx(description["resolution"])
    picture = np.asarray(Image.open(folder / description["image"]))[::-1]
    cells = np.frombuffer(bytes.fromhex(heard["cells"]), np.int8).reshape(heard["height"], heard["width"])
    assert cells.shape == picture.shape
    assert_allclose(cells == 100, picture < 64)
    assert_allclose(cells == 0, picture > 250)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose lidar is in the middle of the base: any other mount would need a transform, which cannot be sent, as
    the wheels of rclpy have no tf2_msgs."""
    folder = tmp_path_factory.mktemp("recorded") / "run"
    settings = [*PLAN, "--set", "lidar.mount.x=0", "--set", "duration=20"]
    with hopslam("run", "corridor", *settings, "--out", folder) as robot:
        robot.output()
    played = [message for message in mcap_messages(folder / "log.mcap") if message.topic in ("/scan", "/odom")]
    lines = (f"{message.topic} {message.type} {message.data.hex()}\n" for message in played)
    (folder / "messages.txt").write_text("".join(lines))
    return folder


def test_what_rclpy_hears_is_the_log_byte_by_byte(client: Path, recorded: Path, tmp_path: Path) -> None:
    """A bag of these messages replays to the same run. The client may be found only after the first second."""
    sent = hopslam("replay", recorded, "--ros", "--set", "slam.mode=dead_reckoning", "--out", tmp_path / "sent")
    with RosNode(client, "record", 90) as node, sent:
        sent.output()
        heard = node.result()["messages"]
    log = tmp_path / "sent" / "log.mcap"
    for wanted in ("/scan", "/odom"):
        received = [data for topic, data in heard if topic == wanted]
        known = [message.data.hex() for message in mcap_messages(log) if message.topic == wanted]
        assert len(received) > len(known) - 20
        assert received == known[-len(received) :]


def test_the_lidar_is_placed_in_the_map_at_every_scan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The transforms map -> odom -> base_link -> laser are received for the time of each scan."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(20 + os.getpid() % 80))
    heard: list[tuple[str, bytes]] = []
    topics = (names.TF_STATIC, names.TF, names.SCAN)
    with open_ros_bus() as bus, run_robot(tmp_path / "run", 5.0) as robot:
        for topic in topics:
            bus.subscribe(topic, partial(lambda name, message: heard.append((name, message)), topic.name))
        robot.output()
        time.sleep(0.5)
    kinds = {topic.name: topic.type for topic in topics}
    messages = [(name, JAZZY.deserialize_cdr(data, kinds[name])) for name, data in heard]
    links = [(link, name) for name, message in messages if name != "/scan" for link in message.transforms]
    scans = [message for name, message in messages if name == "/scan"]
    moving = {(link.header.frame_id, link.child_frame_id, stamp_of(link)) for link, name in links if name == "/tf"}
    assert {(link.header.frame_id, link.child_frame_id) for link, name in links if name == "/tf_static"} == {
        ("base_link", "laser")
    }
    assert len(scans) == 50
    for scan in scans:
        assert scan.header.frame_id == "laser"
        assert {("map", "odom", stamp_of(scan)), ("odom", "base_link", stamp_of(scan))} <= moving


def stamp_of(message: Any) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


@pytest.mark.parametrize("kind", [[], ["stamped"]], ids=["Twist", "TwistStamped"])
def test_a_script_drives_and_the_robot_stands_without_it(client: Path, kind: list[str], tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with RosNode(client, "drive", 90, *kind) as node, run_robot(folder, 20.0) as robot:
        wait_for(folder / "trajectory.tum", 120)
        node.process.kill()
        killed = len((folder / "trajectory.tum").read_text().splitlines())
        robot.output()
    _, poses = read_tum(folder / "groundtruth.tum")
    assert np.hypot(*(poses[killed - 1, :2] - poses[0, :2])) > 1.0
    standing = poses[killed + 15 :]  # after half a second without commands, and braking
    assert len(standing) > 30
    assert_allclose(standing[:, :2], np.broadcast_to(standing[-1, :2], standing[:, :2].shape), atol=2e-3)


SOURCED = """
import time
import numpy as np
from slam.files.ros.encoder import Encoder
from slam.scan import LaserScan
from slam.topics import names
from slam.topics.rclpy_bus import RclpyBus

commands, encoder = [], Encoder()
with RclpyBus() as bus:
    bus.subscribe(names.CMD_VEL, commands.append)
    bus.subscribe(names.STAMPED_CMD_VEL, commands.append)
    for k in range(80):
        scan = LaserScan(0.1 * k, -2.0, 0.01, 0.02, 5.6, np.full(400, 2.0))
        bus.publish(names.SCAN, scan.stamp, encoder.scan(scan))
        time.sleep(0.1)
print(len(commands))
"""
"""A program for a Python that has rclpy, which says how many commands it has heard."""


@pytest.mark.parametrize("kind", [[], ["stamped"]], ids=["Twist", "TwistStamped"])
def test_the_bus_of_a_sourced_ros(client: Path, kind: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    with RosNode(client, "drive", 30, *kind) as node:
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), *site.getsitepackages()]))
        with Program(client, "-c", SOURCED) as program:
            assert int(program.output()) > 40
        assert node.result()["commands"] > 40


def test_garbage_and_sleepers_stop_nothing(client: Path, tmp_path: Path) -> None:
    with RosNode(client, "sleep", 90), RosNode(client, "flood", 8), run_robot(tmp_path / "run", 15.0) as robot:
        assert "duration over" in robot.output()
    stamps, _ = read_tum(tmp_path / "run" / "trajectory.tum")
    assert len(stamps) == 150


def test_slam_on_played_topics_is_that_of_a_replay(client: Path, recorded: Path, tmp_path: Path) -> None:
    with hopslam("replay", recorded, "--scenario", "replay", "--out", tmp_path / "replay") as replay:
        replay.output()
    scans, node = read_tum(tmp_path / "replay" / "trajectory.tum")[0], tmp_path / "node"
    follow = hopslam("ros", "slam", "--set", "ros.reliable=true", "--out", node)
    with follow, RosNode(client, "play", recorded / "messages.txt", 20) as player:
        player.result()
        wait_for(node / "trajectory.tum", len(scans))
        follow.process.send_signal(signal.SIGINT)
        follow.output()
    (stamps, poses), (known, replayed) = (read_tum(made / "trajectory.tum") for made in (node, tmp_path / "replay"))
    assert_allclose(stamps, known, atol=1e-6)
    assert_allclose(poses, replayed, atol=1e-3)


def test_the_back_end_drives_another_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(20 + os.getpid() % 80))
    with run_robot(tmp_path / "robot", 60.0, *BLIND) as robot:
        wait_for(tmp_path / "robot" / "trajectory.tum", 5)
        settings = ["--set", "route.waypoints=[[1.5,0]]", "--set", "duration=30"]
        with hopslam("run", "corridor", "--backend", "ros", *settings, "--out", tmp_path / "driver") as driver:
            assert "arrived" in driver.output()
        robot.process.send_signal(signal.SIGINT)
        robot.output()
    _, poses = read_tum(tmp_path / "robot" / "groundtruth.tum")
    assert np.hypot(*(poses[-1, :2] - poses[0, :2])) > 1.2


def test_an_environment_drives_another_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(20 + os.getpid() % 80))
    with run_robot(tmp_path / "robot", 60.0, *BLIND) as robot:
        wait_for(tmp_path / "robot" / "trajectory.tum", 5)
        env = gymnasium.make("sim:hopslam/Corridor-v0", backend="ros", disable_env_checker=True)
        _, first = env.reset(seed=0)
        for _ in range(30):
            *_, last = env.step(np.array([0.3, 0.0], np.float32))
        env.close()
        robot.process.send_signal(signal.SIGINT)
        robot.output()
    assert (first["pose_from"], last["pose_from"]) == ("estimate", "estimate")
    assert last["pose"][0] - first["pose"][0] > 0.3
