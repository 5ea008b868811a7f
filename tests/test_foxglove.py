"""Topics for the Foxglove app, seen by a client that follows the specification of its protocol.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md, and the subprotocol foxglove.sdk.v1.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from slam.errors import InputError
from slam.files.ros.from_json import cdr_of_json
from slam.files.ros.live_encoder import LiveEncoder
from slam.odometry import Twist2D
from slam.run.experiment_setup import on_topics, scenario_experiment
from slam.run.results.run_record import RunRecord
from slam.run.topics.topic_session import TopicSession
from slam.run.topics.velocity_commands import VelocityCommands
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.topics import names
from slam.topics.topic import Topic
from tests.topic_bus import JAZZY

pytest.importorskip("foxglove", reason="foxglove-sdk is not installed: the extra live")
client = pytest.importorskip("websockets.sync.client", reason="no WebSocket client is installed")

from slam.topics.foxglove_bus import FoxgloveBus  # noqa: E402  # only if foxglove-sdk is installed

MESSAGE_DATA, CLIENT_MESSAGE_DATA = 0x01, 0x01
"""Opcodes of the server's binary frames, and of the client's."""
TWIST = {"linear": {"x": 0.25, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -0.5}}
SCAN = LaserScan(12.5, -1.0, 0.1, 0.06, 4.0, np.linspace(1.0, 3.0, 21))


class App:
    """A client."""

    def __init__(self, socket: Any) -> None:
        self.socket = socket
        self.channels: dict[str, dict[str, Any]] = {}
        assert socket.subprotocol == "foxglove.sdk.v1"
        self.info = json.loads(socket.recv(timeout=5))

    def subscribe(self, topic: str) -> None:
        while topic not in self.channels:
            self._note(json.loads(self.socket.recv(timeout=60)))
        number = self.channels[topic]["id"]
        self._send(op="subscribe", subscriptions=[{"id": number + 100, "channelId": number}])

    def receive(self, again: Callable[[], object] = lambda: None) -> tuple[int, bytes]:
        """Return the time and the data of the next message on a topic; ``again`` is called until one arrives."""
        until = monotonic() + 300.0  # the first run compiles the hot loops
        while monotonic() < until:
            again()
            with suppress(TimeoutError):
                frame = self.socket.recv(timeout=0.1)
                if not isinstance(frame, str):
                    opcode, _, time = struct.unpack("<BIQ", frame[:13])
                    assert opcode == MESSAGE_DATA
                    return time, frame[13:]
                self._note(json.loads(frame))
        raise TimeoutError

    def advertise(self, channel: int, topic: str, encoding: str, schema: str) -> None:
        self._send(
            op="advertise", channels=[{"id": channel, "topic": topic, "encoding": encoding, "schemaName": schema}]
        )

    def say(self, channel: int, data: bytes) -> None:
        self.socket.send(struct.pack("<BI", CLIENT_MESSAGE_DATA, channel) + data)

    def _note(self, message: dict[str, Any]) -> None:
        self.channels |= {channel["topic"]: channel for channel in message.get("channels", ())}

    def _send(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))


@contextmanager
def app_at(bus: FoxgloveBus, **options: Any) -> Iterator[App]:
    with client.connect(bus.address, subprotocols=["foxglove.sdk.v1"], **options) as socket:
        yield App(socket)


@pytest.fixture
def bus() -> Iterator[FoxgloveBus]:
    with FoxgloveBus(port=0) as bus:
        yield bus


def wait_until(reached: Any, seconds: float = 30.0) -> None:
    until = monotonic() + seconds
    while not reached():
        assert monotonic() < until
        sleep(0.01)


def test_an_app_decodes_a_scan_by_the_sent_schema(bus: FoxgloveBus) -> None:
    data = LiveEncoder().scan(SCAN)
    with app_at(bus) as app:
        app.subscribe("/scan")
        time, received = app.receive(lambda: bus.publish(names.SCAN, SCAN.stamp, data))
    channel = app.channels["/scan"]
    assert "clientPublish" in app.info["capabilities"]
    assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(channel["schema"], channel["schemaName"]))
    message = store.deserialize_cdr(received, channel["schemaName"])
    assert time == 12_500_000_000
    np.testing.assert_array_equal(message.ranges, SCAN.ranges.astype(np.float32))
    assert message.header.frame_id == "laser"


def test_a_late_client_gets_the_last_map(bus: FoxgloveBus) -> None:
    for stamp in (1.0, 2.0):
        grid = LiveEncoder().grid(stamp, np.full((3, 4), int(stamp), np.int8), np.zeros(2), 0.05)
        bus.publish(names.MAP, stamp, grid)
    with app_at(bus) as app:
        app.subscribe("/map")
        assert app.receive() == (2_000_000_000, grid)


@pytest.mark.parametrize("topic", [names.CMD_VEL, names.STAMPED_CMD_VEL])
@pytest.mark.parametrize("encoding", ["json", "cdr"])
def test_an_app_drives_the_robot(bus: FoxgloveBus, topic: Topic, encoding: str) -> None:
    commands = VelocityCommands()
    commands.listen(bus)
    command = TWIST if topic is names.CMD_VEL else {"header": {"frame_id": "base_link"}, "twist": TWIST}
    data = json.dumps(command).encode()
    with app_at(bus) as app:
        app.advertise(7, "/cmd_vel", encoding, topic.type.replace("/msg/", "/"))
        app.say(7, data if encoding == "json" else cdr_of_json(data, topic.type))
        wait_until(lambda: commands.count)
    assert commands.twist == Twist2D(0.25, -0.5)
    assert commands.garbage == 0


def test_garbage_is_counted_and_warned_of_once(bus: FoxgloveBus, caplog: pytest.LogCaptureFixture) -> None:
    commands = VelocityCommands()
    commands.listen(bus)
    not_finite = cdr_of_json(json.dumps(TWIST).encode(), names.CMD_VEL.type)[:-8] + struct.pack("<d", float("nan"))
    garbage = [b"", b"{", b"[1]", b"[" * 9000, b'{"linear": 3}', b'{"linear": {"x": 1e400}}', bytes(100_000)]
    with app_at(bus) as app:
        app.advertise(1, "/cmd_vel", "json", "geometry_msgs/Twist")
        app.advertise(2, "/cmd_vel", "cdr", "geometry_msgs/Twist")
        app.advertise(3, "/cmd_vel", "cdr", "no_msgs/Twist")
        for data in garbage:
            app.say(1, data)
            app.say(2, data)
            app.say(3, data)
        app.say(2, not_finite)
        app.socket.send(b"\x77 no such opcode")
        app.socket.send("{}")
        wait_until(lambda: commands.garbage == 2 * len(garbage) + 1)
        app.say(1, json.dumps(TWIST).encode())
        wait_until(lambda: commands.count == 1)
    assert len(caplog.records) == 1


def test_an_app_that_does_not_read_delays_nobody(bus: FoxgloveBus) -> None:
    data = bytes(100_000)
    with app_at(bus, close_timeout=0.1) as app, app_at(bus, max_queue=1) as stuck:
        for each in (stuck, app):
            each.subscribe("/scan")
            each.receive(lambda: bus.publish(names.SCAN, 0.0, data))
        for k in range(2000):  # 200 MB, more than any buffer takes
            bus.publish(names.SCAN, 0.1 * k, data)
        stuck.socket.close_socket()
        app.receive(lambda: bus.publish(names.SCAN, 1e3, data))


def test_a_robot_stops_without_commands(tmp_path: Path) -> None:
    bus, stood = FoxgloveBus(port=0), Event()

    def speed(app: App) -> float:
        return float(JAZZY.deserialize_cdr(app.receive()[1], names.ODOM.type).twist.twist.linear.x)

    def drive() -> None:
        with app_at(bus, close_timeout=1.0) as app:
            app.subscribe("/odom")
            app.advertise(1, "/cmd_vel", "json", "geometry_msgs/Twist")
            while speed(app) < 0.1:
                app.say(1, json.dumps(TWIST).encode())
            while speed(app) > 0.0:
                pass
            stood.set()

    driver = Thread(target=drive)
    with TopicSession([bus], pace=4.0) as topics:
        scenario = load_scenario("corridor", ["duration=20", "physics.engine=plan", "route.waypoints=[]"])
        experiment = on_topics(scenario_experiment(scenario), topics)
        driver.start()
        outcome = experiment.run(tmp_path / "run", pictures=False)
        driver.join()
    steps = RunRecord.open(outcome.folder).traces.steps
    assert stood.is_set()
    assert {(0.25, -0.5), (0.0, 0.0)} == set(zip(steps["v"].tolist(), steps["omega"].tolist(), strict=True))


def test_a_port_in_use_is_reported(bus: FoxgloveBus) -> None:
    port = int(bus.address.rpartition(":")[2])
    with pytest.raises(InputError, match=r"in use .*; choose another port"), FoxgloveBus(port=port):
        pass
