"""Logs of many kinds of lidar, clock and odometry are read like the same log in its clean form."""

import sqlite3
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer

from slam.cli.main import main
from slam.errors import LogError
from slam.files.logs import BagTopics, Log, bag, read_log
from slam.files.logs.odometry_resets import join_resets
from slam.files.logs.stamps import increasing
from slam.files.ros.encoder import Encoder
from slam.files.ros.mcap_files import McapWriter
from slam.files.ros.messages import LASER_SCAN, MULTI_ECHO, ODOMETRY, TF, TF_STATIC, TRANSFORMS, RawMessage, ros2_types
from slam.odometry import Odometry, Twist2D
from slam.pose import FloatArray, Pose2D
from slam.run.experiment_setup import replay_experiment
from slam.run.export.carmen import write_carmen
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import Traces
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from slam.sweep.make_plan import make_plan
from slam.sweep.run_job import run_job

ENCODER = Encoder()
SCANS, EPOCH, STEP = 40, 1_700_000_000.0, 2.0 * pi / 120
MOUNT = Pose2D(0.1, 0.05, 0.4)
ROOM = np.array([3.0, 2.5])
"""Half the length and width of the room, metres, whose middle is the origin."""


def on_circle(time: float) -> Pose2D:
    """Pose ``time`` seconds after the start of a drive round a circle."""
    angle = 0.5 * time
    return Pose2D(np.cos(angle), np.sin(angle), angle + pi / 2)


def seen(pose: Pose2D, bearings: FloatArray) -> FloatArray:
    """Ranges to the walls of the room."""
    heading = np.column_stack([np.cos(pose.theta + bearings), np.sin(pose.theta + bearings)])
    with np.errstate(divide="ignore"):
        to_walls = (np.sign(heading) * ROOM - [pose.x, pose.y]) / heading
    return np.asarray(to_walls.min(axis=1).round(3))


@dataclass(frozen=True)
class Lidar:
    """Beams of a test's lidar, as its driver has them."""

    first: float = -pi
    step: float = STEP
    beams: int = 120
    time_increment: float = 0.0
    inverted: bool = False

    def scan(self, time: float) -> LaserScan:
        bearings = self.first + self.step * np.arange(self.beams)
        sign = -1.0 if self.inverted else 1.0
        ranges = [
            seen(on_circle(time + j * self.time_increment) @ MOUNT, np.array([sign * bearing]))[0]
            for j, bearing in enumerate(bearings)
        ]
        return LaserScan(EPOCH + time, self.first, self.step, 0.1, 12.0, np.array(ranges), self.time_increment)


STRAIGHT = Lidar()
TIMES = [0.1 * index for index in range(SCANS)]
Change = Callable[[Any], Any]


def raw(topic: str, kind: str, data: bytes, time: float) -> RawMessage:
    return RawMessage(topic, kind, "cdr", data, round(1e9 * (EPOCH + time)))


def changed(message: RawMessage, change: Change) -> RawMessage:
    """The message, its decoded value changed."""
    value = ros2_types().deserialize_cdr(message.data, message.type)
    change(value)
    return message._replace(data=bytes(ros2_types().serialize_cdr(value, message.type)))


def put(value: Any, **fields: Any) -> None:
    for name, field in fields.items():
        object.__setattr__(value, name, field)


def mount(quaternion: Sequence[float] | None = None, topic: str = TF_STATIC, frame: str = "laser") -> RawMessage:
    """The transform from base_link to the laser."""
    data = ENCODER.transforms(EPOCH, ("base_link", frame, MOUNT))
    message = raw(topic, TRANSFORMS, data, 0.0)
    if quaternion is None:
        return message
    turned = ros2_types().types["geometry_msgs/msg/Quaternion"](*quaternion)
    return changed(message, lambda value: put(value.transforms[0].transform, rotation=turned))


def scans(lidar: Lidar | Callable[[int], Lidar] = STRAIGHT, topic: str = "/scan") -> list[RawMessage]:
    lidars = (lidar(index) if callable(lidar) else lidar for index in range(SCANS))
    return [
        raw(topic, LASER_SCAN, ENCODER.scan(one.scan(time)), time + 0.002)
        for time, one in zip(TIMES, lidars, strict=True)
    ]


def odometry(times: Sequence[float] = TIMES, pose: Callable[[float], Pose2D] = on_circle) -> list[RawMessage]:
    values = [Odometry(EPOCH + time, pose(time), Twist2D(0.5, 0.5)) for time in times]
    return [raw("/odom", ODOMETRY, ENCODER.odometry(value), time) for value, time in zip(values, times, strict=True)]


def read(*parts: Sequence[RawMessage], topics: BagTopics | None = None) -> Log:
    """The log of these messages, in the order of their receipt."""
    messages = sorted((message for part in parts for message in part), key=lambda message: message.time)
    return bag.read(Path("test.bag"), lambda _: iter(messages), topics or BagTopics())


TIDY = read([mount()], scans(), odometry())


def points(log: Log, index: int) -> FloatArray:
    """End points of a scan in the frame where the log began."""
    return (log.pose(index) @ log.T_base_laser).transform(log.scan(index).points())


def assert_is_tidy(log: Log, stamps: bool = True, within: float = 2e-3) -> None:
    """The log has all scans and poses of the tidy log."""
    assert len(log) == SCANS
    np.testing.assert_allclose(log.T_odom_base, TIDY.T_odom_base, atol=within)
    if stamps:
        np.testing.assert_allclose(log.stamps, TIDY.stamps, atol=0.01)
    assert_shows_the_room(log, within)


def assert_shows_the_room(log: Log, within: float = 2e-3) -> None:
    """All end points lie on the walls."""
    start = on_circle(0.0)
    for index in range(0, len(log), 7):
        from_walls = np.abs(np.abs(start.transform(points(log, index))) - ROOM).min(axis=1)
        assert from_walls.max() < within + 2e-3


# Lidars


def test_the_clean_log_shows_the_room() -> None:
    assert TIDY.report == "40 scans"
    assert_shows_the_room(TIDY)


def test_scans_of_any_number_of_beams_keep_their_fans() -> None:
    counts = np.random.default_rng(1).integers(90, 140, SCANS).tolist()
    log = read([mount()], scans(lambda index: Lidar(step=2.0 * pi / counts[index], beams=counts[index])), odometry())
    assert_is_tidy(log)
    assert [len(log.scan(index).ranges) for index in range(SCANS)] == counts
    assert f"{min(counts)} to {max(counts)} beams a scan" in log.report


@pytest.mark.parametrize("padding", [np.nan, np.inf, 0.0])
def test_padding_of_scans_is_read_as_no_echo(padding: float) -> None:
    def pad(message: RawMessage) -> RawMessage:
        def change(scan: Any) -> None:
            ranges = np.append(scan.ranges[:100], np.full(20, padding, np.float32)).astype(np.float32)
            put(scan, ranges=ranges, intensities=np.ones(7, np.float32), range_min=0.0)

        return changed(message, change)

    log = read([mount()], [pad(message) for message in scans()], odometry())
    assert_is_tidy(log)
    assert log.scan(3).echoes.sum() == 100


@pytest.mark.parametrize("between", [0.0, 0.0008, -0.0008])
def test_a_clockwise_scan_is_read_in_reverse_order(between: float) -> None:
    clockwise = Lidar(first=pi - STEP, step=-STEP, time_increment=between)
    twin = Lidar(time_increment=-between)
    log = read([mount()], scans(clockwise), odometry())
    assert log.lidar.angle_increment == pytest.approx(STEP)
    assert log.time_increment == pytest.approx(-between)
    for index in (0, 20):
        scan, time = log.scan(index), TIMES[index] + 119 * between
        assert scan.stamp == pytest.approx(EPOCH + time, abs=1e-6)
        np.testing.assert_allclose(scan.ranges, twin.scan(time).ranges, atol=1.1e-3)
        np.testing.assert_allclose(scan.bearings, -pi + STEP * np.arange(120), atol=1e-6)


UPSIDE_DOWN = {
    "roll pi, yaw": (np.cos(0.2), np.sin(0.2), 0.0, 0.0),
    "pitch pi, yaw": (-np.sin(0.2 + pi / 2), np.cos(0.2 + pi / 2), 0.0, 0.0),
    "not normalised": (2.0 * np.cos(0.2), 2.0 * np.sin(0.2), 0.0, 0.0),
}


@pytest.mark.parametrize("lidar", [Lidar(inverted=True), Lidar(pi - STEP, -STEP, inverted=True)], ids=["ccw", "cw"])
@pytest.mark.parametrize("quaternion", list(UPSIDE_DOWN.values())[::2], ids=list(UPSIDE_DOWN)[::2])
def test_a_lidar_upside_down_reads_as_upright(quaternion: Sequence[float], lidar: Lidar) -> None:
    log = read([mount(quaternion)], scans(lidar), odometry())
    assert_is_tidy(log)
    assert "laser hangs upside down" in log.report


def test_half_a_roll_over_two_transforms_is_upside_down() -> None:
    quarter = ros2_types().types["geometry_msgs/msg/Quaternion"](0.5**0.5, 0.0, 0.0, 0.5**0.5)
    links = ("base_link", "arm", MOUNT), ("arm", "hand", Pose2D()), ("hand", "laser", Pose2D())

    def roll(value: Any) -> None:
        for link in value.transforms[1:]:
            put(link.transform, rotation=quarter)

    transforms = changed(raw(TF_STATIC, TRANSFORMS, ENCODER.transforms(EPOCH, *links), 0.0), roll)
    assert_is_tidy(read([transforms], scans(Lidar(inverted=True)), odometry()))


def test_the_lidar_with_most_scans_is_read() -> None:
    rear = scans(topic="/rear")[::2]
    log = read([mount()], scans(topic="/front"), rear, odometry())
    assert_is_tidy(log)
    assert "/front (40), /rear (20); /front is read, --scan-topic NAME chooses another" in log.report
    assert len(read([mount()], scans(topic="/front"), rear, odometry(), topics=BagTopics(scan="rear"))) == SCANS // 2


def test_the_most_frequent_frame_of_a_topic_is_read() -> None:
    other = [changed(message, lambda scan: put(scan.header, frame_id="rear")) for message in scans()[::3]]
    log = read([mount()], scans(), other, odometry())
    assert_is_tidy(log)
    assert "14 scans of another lidar, whose frame is rear" in log.report


def test_the_first_echoes_of_a_multi_echo_lidar_are_read() -> None:
    types = ros2_types().types

    def echoes(message: RawMessage) -> RawMessage:
        scan = ros2_types().deserialize_cdr(message.data, LASER_SCAN)
        beams = [types["sensor_msgs/msg/LaserEcho"](np.array([r, r + 1.0], np.float32)) for r in scan.ranges]
        fields = {name: getattr(scan, name) for name in types[MULTI_ECHO].__dataclass_fields__ if name[0] != "_"}
        value = types[MULTI_ECHO](**(fields | {"ranges": beams, "intensities": []}))
        return message._replace(type=MULTI_ECHO, data=bytes(ros2_types().serialize_cdr(value, MULTI_ECHO)))

    log = read([mount()], [echoes(message) for message in scans()], odometry())
    assert_is_tidy(log)
    assert "the first echo is read" in log.report


def test_frames_with_slashes_are_the_same_frames() -> None:
    slashed = [changed(message, lambda scan: put(scan.header, frame_id="/laser")) for message in scans()]
    assert_is_tidy(read([mount()], slashed, odometry()))


@pytest.mark.parametrize("topic", [TF, TF_STATIC])
def test_the_mount_may_follow_the_first_scan(topic: str) -> None:
    assert_is_tidy(read([mount(topic=topic)._replace(time=round(1e9 * (EPOCH + 3.9)))], scans(), odometry()))


# Clocks


def at(messages: Sequence[RawMessage], stamp: Callable[[int, float], float]) -> list[RawMessage]:
    """The messages with stamps made of their index and time."""

    def change(value: Any, index: int) -> None:
        time = stamp(index, TIMES[index])
        seconds = int(time // 1)
        put(value.header.stamp, sec=seconds, nanosec=int(1e9 * (time - seconds)))

    return [
        changed(message, lambda value, index=index: change(value, index))  # type: ignore[misc]
        for index, message in enumerate(messages)
    ]


@pytest.mark.parametrize("stamp", [0.0, 5000.0])
@pytest.mark.parametrize("of_odometry", [True, False])
def test_equal_stamps_are_replaced_by_times_of_receipt(stamp: float, of_odometry: bool) -> None:
    moving = at(odometry(), lambda *_: stamp) if of_odometry else odometry()
    log = read([mount()], at(scans(), lambda *_: stamp), moving)
    assert_is_tidy(log, within=0.01)
    assert "stamps that are zero or equal, times of receipt used (40: messages" in log.report


@pytest.mark.parametrize("half", [SCANS // 2, 8, 31])
def test_a_clock_set_back_loses_no_scan(half: int) -> None:
    def stamp(index: int, time: float) -> float:
        return EPOCH + time - 3600.0 * (index >= half)

    log = read([mount()], at(scans(), stamp), at(odometry(), stamp))
    assert_is_tidy(log, stamps=False, within=0.01)
    np.testing.assert_allclose(log.stamps - log.stamps[0], TIMES, atol=0.01)
    assert "clock that was set back, corrected: -3599.900 s (1: message" in log.report


def test_stamps_a_little_out_of_order_keep_their_place() -> None:
    log = read([mount()], at(scans(), lambda index, time: EPOCH + time - 0.103 * (index % 10 == 9)), odometry())
    assert_is_tidy(log, within=0.1)
    assert "stamps that do not increase, set between their neighbours (4: messages" in log.report


def test_scans_of_another_epoch_match_their_odometry() -> None:
    log = read([mount()], at(scans(), lambda _, time: 100.0 + time), odometry())
    assert_is_tidy(log, stamps=False, within=0.01)
    assert log.stamps[0] == pytest.approx(100.0)
    assert "40 of 40 stamps of its odometry are of another clock than its scans" in log.report


def test_a_whole_log_of_another_epoch_stays_as_it_is() -> None:
    def stamp(_: int, time: float) -> float:
        return 100.0 + time

    log = read([mount()], at(scans(), stamp), at(odometry(), stamp))
    assert log.report == "40 scans"
    np.testing.assert_allclose(log.stamps, [100.0 + time for time in TIMES])


@pytest.mark.parametrize("count", [1, 2, 10, 57])
def test_corrected_stamps_always_increase(count: int) -> None:
    random = np.random.default_rng(count)
    for _ in range(20):
        stamps = random.integers(0, 2 * count, count).astype(float)
        corrected = increasing(stamps)
        assert (np.diff(corrected.stamps) > 0.0).all()
        assert len(corrected.stamps) == count


# Odometry


@pytest.mark.parametrize("resets", [[20], [12, 25]])
@pytest.mark.parametrize("landing", [Pose2D(), Pose2D(7.0, -3.0, 1.0)])
def test_odometry_that_is_reset_is_joined(resets: list[int], landing: Pose2D) -> None:
    def pose(time: float) -> Pose2D:
        before = [index for index in resets if round(10 * time) >= index]
        return landing @ on_circle(0.1 * before[-1]).inverse() @ on_circle(time) if before else on_circle(time)

    log = read([mount()], scans(), odometry(pose=pose))
    assert_is_tidy(log, within=0.02)
    times = f"{len(resets)} time{'s' * (len(resets) > 1)}"
    assert f"its odometry was reset {times}, at {resets[0] / 10:.3f} s" in log.report


def test_a_joined_track_keeps_every_other_step() -> None:
    times = np.arange(50) / 10
    poses = np.array([on_circle(time).as_array() for time in times])
    broken = poses.copy()
    broken[30:] = broken[30:] * 0.0 + [5.0, 5.0, 0.0]
    assert join_resets(times, poses).poses is poses
    joined = join_resets(times, broken)
    assert list(joined.resets) == [30]
    np.testing.assert_array_equal(joined.poses[:30], poses[:30])
    np.testing.assert_allclose(joined.poses[30:], np.tile(joined.poses[30], (20, 1)))


@pytest.mark.parametrize(
    ("times", "note"),
    [
        ([0.0, 1.0, 2.0, 3.0, 4.0], ""),
        (
            [time for time in TIMES if not 1.0 < time < 3.0],
            "1 gap in its odometry, 2.0 s in all, the first at 1.0 to 3.0 s",
        ),
        ([time for time in TIMES if time > 1.55], "does not cover the time of its scans; 1 gap in its odometry, 1.6 s"),
    ],
    ids=["slow", "absent", "late"],
)
def test_missing_odometry_is_noted(times: list[float], note: str) -> None:
    log = read([mount()], scans(), odometry(times))
    assert len(log) == SCANS
    assert note in log.report if note else log.report == "40 scans"


def test_odometry_of_transforms_alone_is_enough() -> None:
    moving = [
        raw(TF, TRANSFORMS, ENCODER.transforms(EPOCH + time, ("/odom", "/base_link", on_circle(time))), time)
        for time in TIMES
    ]
    assert_is_tidy(read([mount()], scans(), moving))


def test_a_mount_on_another_base_frame_is_used() -> None:
    footprint = [changed(message, lambda value: put(value, child_frame_id="base_footprint")) for message in odometry()]
    assert_is_tidy(read([mount()], scans(), footprint))


# Loss


def broken(share: int) -> list[RawMessage]:
    return [
        changed(message, lambda scan: put(scan, range_max=-1.0)) if index % 10 < share else message
        for index, message in enumerate(scans())
    ]


def test_an_impossible_field_is_named_with_its_message() -> None:
    log = read([mount()], broken(1), odometry())
    assert "36 scans, 4 messages skipped (4 impossible value: range_max -1, messages 3 to 63)" in log.report


@pytest.mark.parametrize(("share", "warned", "failed"), [(2, False, False), (3, True, False), (6, True, True)])
def test_losing_over_half_of_the_scans_is_an_error(share: int, warned: bool, failed: bool) -> None:
    loss = read([mount()], broken(share), odometry()).loss
    assert (loss.warning is not None) is warned
    loss.require_most(lenient=True)
    if failed:
        with pytest.raises(LogError, match=r"24 of 40 scans of the log, 60%, .*range_max -1.*--lenient"):
            loss.require_most(lenient=False)
    else:
        loss.require_most(lenient=False)


# Files


@pytest.mark.parametrize(
    ("begin", "message"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "Git LFS pointer.*git lfs pull"),
        (b"#ROSRECORD V1.2\nfile_pos=1\n", "before 2.0; .* rosbag filter"),
        (b"#ROSBAG V1.2\n", "before 2.0; .* rosbag filter"),
        (b"\x8dCActionCollection\x00", "an MRPT rawlog; give the CARMEN log"),
    ],
)
def test_files_that_are_not_logs_name_the_next_step(tmp_path: Path, begin: bytes, message: str) -> None:
    path = tmp_path / "thing.log"
    path.write_bytes(begin)
    with pytest.raises(LogError, match=message):
        read_log(path)


def test_cmu_text_is_read_in_centimetres(tmp_path: Path) -> None:
    ranges = " ".join(["150"] * 179 + ["8183"])
    lines = [f"O {10 * k} 0 0 {k}.05\nL {10 * k} 0 0 {10 * k + 25} 0 0 {ranges} {k}.1" for k in range(5)]
    path = tmp_path / "robotdata.log"
    path.write_text("\n".join(lines))
    log = read_log(path)
    np.testing.assert_allclose(log.T_odom_base[:, 0], 0.1 * np.arange(5))
    assert log.T_base_laser.x == pytest.approx(0.25)
    assert log.lidar.beams == 180
    assert log.scan(0).ranges[0] == 1.5
    assert log.scan(0).ranges[-1] == np.inf
    assert log.ignored == {"O": 5}


def test_carmen_stamps_of_six_digits_keep_all_scans(tmp_path: Path) -> None:
    ranges = [" ".join(f"{r:.2f}" for r in 2.0 + np.random.default_rng(k).random(180)) for k in range(9)]
    lines = [f"FLASER 180 {row} 0 {k / 10} 0 0 {k / 10} 0 1.7e+09 host 1.7e+09" for k, row in enumerate(ranges)]
    path = tmp_path / "corrected.log"
    path.write_text("\n".join(lines))
    log = read_log(path)
    np.testing.assert_allclose(log.stamps, 1.7e9 + 0.1 * np.arange(9))
    assert log.report == (
        "9 scans; stamps that are zero or equal, taken in the order of the file as 10 scans a second (9: lines 1 to 9)"
    )


def write_bag(folder: Path, mode: CompressionMode = CompressionMode.NONE) -> Path:
    """A ROS 2 bag of the tidy log, sqlite3."""
    writer = Writer(folder, version=9)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        ids: dict[tuple[str, str], Any] = {}
        for message in [mount(), *scans(), *odometry()]:
            key = message.topic, message.type
            ids[key] = ids.get(key) or writer.add_connection(*key, typestore=ros2_types())
            writer.write(ids[key], message.time, message.data)
    return folder


@pytest.mark.parametrize("mode", list(CompressionMode)[:3])
def test_a_bag_without_metadata_is_read(tmp_path: Path, mode: CompressionMode) -> None:
    folder = write_bag(tmp_path / "bag", mode)
    assert_is_tidy(read_log(folder))
    file = next(path for path in folder.iterdir() if ".db3" in path.name)
    assert_is_tidy(read_log(file))
    (folder / "metadata.yaml").unlink()
    log = read_log(folder)
    assert_is_tidy(log)
    assert "it has no metadata.yaml" in log.report


def test_a_bag_in_parts_is_one_log(tmp_path: Path) -> None:
    whole = next(write_bag(tmp_path / "bag").glob("*.db3")).read_bytes()
    for part in range(12):
        path = tmp_path / f"split_{part}.db3"
        path.write_bytes(whole)
        with sqlite3.connect(path) as database:
            database.execute("DELETE FROM messages WHERE id % 81 / 7 <> ?", (part,))
        database.close()
    rmtree(tmp_path / "bag")
    log = read_log(tmp_path)
    assert len(log) == SCANS
    assert_shows_the_room(log)


# Runs


def write_mcap(path: Path, messages: Sequence[RawMessage]) -> None:
    writer = McapWriter(path, ENCODER, 10_000)
    for message in sorted(messages, key=lambda message: message.time):
        writer.write(message.topic, message.time, message.data)
    writer.close()


@pytest.fixture(scope="module")
def varying(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """MCAP file of a lidar that turns clockwise, and whose scans differ in their number of beams."""
    path = tmp_path_factory.mktemp("varying") / "rplidar.mcap"
    lidars = [Lidar(pi - 2.0 * pi / n, -2.0 * pi / n, n) for n in (100, 111, 119, 108)]
    messages = [mount(), *scans(lambda index: lidars[index % 4]), *odometry()]
    write_mcap(path, messages)
    return path


@pytest.fixture(scope="module")
def varying_run(varying: Path) -> Path:
    return replay_experiment(varying, load_scenario("replay")).run(varying.parent / "run", pictures=False).folder


def test_a_run_of_varying_beams_follows_the_truth(varying_run: Path) -> None:
    traces = Traces.read(varying_run)
    assert traces is not None
    assert len(traces.estimate) == SCANS
    np.testing.assert_allclose(traces.estimate[:, :2], TIDY.T_odom_base[:, :2], atol=0.02)


def test_a_run_of_varying_beams_replays_bit_for_bit(varying_run: Path, tmp_path: Path) -> None:
    first, again = read_log(varying_run), tmp_path / "again.log"
    write_carmen(RunRecord.open(varying_run), again)
    for log in (first, read_log(again)):
        assert [len(log.scan(index).ranges) for index in range(4)] == [100, 111, 119, 108]
        assert_shows_the_room(log, within=0.02)
    folder = replay_experiment(varying_run, load_scenario("replay")).run(tmp_path / "again", pictures=False).folder
    assert (folder / "trajectory.tum").read_bytes() == (varying_run / "trajectory.tum").read_bytes()


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.parametrize("command", ["replay", "lines", "localize"])
def test_a_command_fails_on_a_log_that_is_mostly_lost(
    tmp_path: Path, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.mcap"
    write_mcap(path, [mount(), *broken(6), *odometry()])
    words = {
        "replay": ["replay", str(path), "--out", "run"],
        "lines": ["lines", str(path)],
        "localize": ["localize", str(path), "--map", "map/map.json", "--out", "run"],
    }[command]
    codes = []
    monkeypatch.chdir(tmp_path)
    if command == "localize":
        write_mcap(tmp_path / "whole.mcap", [mount(), *scans(), *odometry()])
        replay_experiment(tmp_path / "whole.mcap", load_scenario("replay")).run(tmp_path / "map", pictures=False)
    for lenient in ([], ["--lenient"]):
        rmtree("run", ignore_errors=True)
        monkeypatch.setattr("sys.argv", ["hopslam", *words, *lenient])
        with pytest.raises(SystemExit) as left:
            main()
        codes.append(left.value.code)
        assert "warning: 24 of 40 scans of the log, 60%, could not be used" in capsys.readouterr().err
    assert codes == [4, 0]


def test_a_run_of_a_sweep_fails_on_a_log_that_is_mostly_lost(tmp_path: Path) -> None:
    write_mcap(tmp_path / "broken.mcap", [mount(), *broken(6), *odometry()])
    write_mcap(tmp_path / "whole.mcap", [mount(), *broken(3), *odometry()])
    logs = [str(tmp_path / name) for name in ("broken.mcap", "whole.mcap")]
    plan = make_plan(logs, {"modes": ["dead_reckoning"]})
    lost, whole = (run_job(job, str(tmp_path / "runs"), pictures=False) for job in plan.jobs())
    assert lost is not None
    assert whole is not None
    assert (lost["status"], whole["status"]) == ("failed", "done")
    assert "24 of 40 scans of the log, 60%, could not be used" in lost["error"]
    assert lost["error"].endswith("mend the log, or leave it out of the sweep")
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [whole["id"]]
