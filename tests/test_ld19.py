"""The LD19 lidar of LDROBOT by its manual: decoded, simulated, emulated and driven."""

import time
from collections.abc import Sequence
from math import inf, pi, radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.doctor import examine
from hardware.emulator.emulator import Emulator
from hardware.emulator.ld19 import EmulatedLd19
from hardware.ldrobot import SIZE, LdDecoder, LdPacket
from hardware.lidars.ld_turns import TurnCollector
from hardware.robot import HardwareRobot
from sim.plant import SimPlant
from sim.robot import SimRobot
from slam.console.terminal import Terminal
from slam.deskew import deskewed
from slam.env.p3dx_env import P3DXEnv
from slam.lidars import LD19, LIDARS, Lidar
from slam.odometry import Twist2D
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.experiment_setup import scenario_experiment
from slam.run.gym_arrays import nearest_beams, scan_array
from slam.scan import LaserScan
from slam.scenario.file import load_scenario
from tests.rooms import room_plant

MANUAL = bytes.fromhex(
    "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 E2 C7 00 E9 C5 00 E5"
    "C2 00 E5 C0 00 E5 BE 82 3A 1A 50"
)
"""The example of the LD19 Development Manual."""


def plant() -> SimPlant:
    return room_plant((-2.0, 3.5), (-2.0, 2.0), 0.16, "ld19")


def to_walls(points: FloatArray) -> FloatArray:
    """Distance of points from the walls of the room."""
    x, y = points.T
    return np.minimum.reduce([abs(x + 2.0), abs(x - 3.5), abs(y + 2.0), abs(y - 2.0)])


def emulated_bytes(turns: float = 1.2, rate: float = 10.0) -> bytes:
    device = EmulatedLd19(plant(), rate=rate)
    data = b""
    while device.due < turns / rate:
        data += device.step()
    return data


def test_the_example_of_the_manual_is_decoded() -> None:
    packet = LdPacket.decode(MANUAL)
    assert packet.speed == pytest.approx(radians(2152))
    assert np.degrees([packet.first, packet.last]) == pytest.approx([324.27, 334.70])
    assert packet.angles[1] - packet.angles[0] == pytest.approx(radians((334.70 - 324.27) / 11))
    assert (1000 * packet.ranges).round().tolist() == [224, 220, 217, 213, 211, 208, 205, 202, 199, 197, 194, 192]
    assert packet.intensities[:3] == (228, 226, 229)
    assert packet.time == 6.714
    assert packet.encode() == MANUAL


@given(st.lists(st.binary(max_size=20).filter(lambda junk: b"\x54" not in junk), max_size=5), st.integers(1, 60))
def test_packets_are_found_in_any_stream(junk: list[bytes], size: int) -> None:
    stream = b"".join(part + MANUAL for part in junk)
    decoder = LdDecoder()
    found = [packet for k in range(0, len(stream), size) for packet in decoder.feed(stream[k : k + size])]
    assert [packet.time for packet in found] == [6.714] * len(junk)


@given(st.integers(0, SIZE * 3 - 1), st.integers(1, 255))
def test_a_damaged_packet_loses_no_other_packet(place: int, flips: int) -> None:
    stream = bytearray(MANUAL * 3)
    stream[place] ^= flips
    assert len(LdDecoder().feed(bytes(stream))) == 2


def test_lds2d_reads_the_emulated_bytes_alike() -> None:
    """The package lds2d is by others; it knows this sensor from LDROBOT's own SDK."""
    lds2d = pytest.importorskip("lds2d.drivers.ldrobot_ld14p")
    crc = pytest.importorskip("lds2d.crc")
    data = emulated_bytes()
    assert len(data) > 40 * SIZE
    for k in range(0, len(data), SIZE):
        packet = data[k : k + SIZE]
        assert crc.crc8(packet[:-1]) == packet[-1]
        frequency, points = lds2d.parse_packet(packet)
        ours = LdPacket.decode(packet)
        assert frequency == pytest.approx(ours.speed / (2.0 * pi))
        assert [point.angle_deg for point in points] == pytest.approx(np.degrees(ours.angles % (2.0 * pi)).tolist())
        millimetres = [0.0 if metres == inf else 1000.0 * metres for metres in ours.ranges.tolist()]
        assert [point.dist_mm for point in points] == pytest.approx(millimetres)


def scans_of(packets: Sequence[LdPacket]) -> list[LaserScan]:
    turns = TurnCollector()
    whole = [turns.add(packet, packet.time) for packet in packets]
    return [turn.scan(0.02, 12.0) for turn in whole if turn is not None]


@pytest.mark.parametrize("rate", [5.0, 10.0])
def test_a_turn_is_a_scan_of_the_room(rate: float) -> None:
    (scan, *_) = scans_of(LdDecoder().feed(emulated_bytes(2.6, rate)))
    assert len(scan.ranges) == pytest.approx(4500.0 / rate, rel=0.03)
    assert scan.angle_increment * len(scan.ranges) == pytest.approx(2.0 * pi, rel=0.01)
    assert abs(scan.angle_min + pi) < 1.5 * scan.angle_increment  # behind the robot
    assert scan.scan_time == pytest.approx(1.0 / rate, rel=0.03)
    assert scan.time_increment == pytest.approx(-1.0 / 4500.0, rel=0.02)
    assert to_walls(scan.points() + np.array([0.16, 0.0])).max() < 0.01  # the step of the angle is rounded


def test_lost_packets_are_errors_and_not_walls() -> None:
    packets = LdDecoder().feed(emulated_bytes(2.6))
    whole = scans_of(packets)[0]
    holed = scans_of([packet for k, packet in enumerate(packets) if k % 9 != 5])[0]
    missing = np.isnan(holed.ranges)
    assert missing.sum() == pytest.approx(len(holed.ranges) / 9, abs=13)
    assert len(holed.ranges) == len(whole.ranges)
    assert holed.ranges[~missing] == pytest.approx(whole.ranges[~missing], abs=0.002)


def test_the_driver_sees_the_room_and_stops_without_scans() -> None:
    with (
        Emulator(plant(), lidar="ld19") as emulator,
        HardwareRobot(load_scenario("corridor", emulator.port_settings), yes=True) as robot,
    ):
        seen = []
        for _ in range(12):
            robot.drive(Twist2D(0.2, 0.5))
            observation = robot.observe(5.0)
            assert observation is not None
            seen.append(observation)
        emulator.do(lambda: emulator.scanner.set_dead(True))
        until = time.monotonic() + 20.0
        while emulator.p3dx.motors.moving and time.monotonic() < until:
            robot.drive(Twist2D(0.2, 0.0))
            time.sleep(0.02)
        assert not emulator.p3dx.motors.moving
        assert "no scan" in str(robot.trouble)
    assert len({len(observation.scan.ranges) for observation in seen}) > 1
    off = [to_walls(points_of(observation, robot.T_base_laser)) for observation in seen[6:]]
    assert np.median([np.median(distances) for distances in off]) < 0.01  # a busy machine delays one or two


def points_of(observation: Observation, T_base_laser: Pose2D) -> FloatArray:
    """The points of a scan, deskewed, in the odometry's frame."""
    scan = deskewed(observation.scan, observation.odometry.twist, T_base_laser)
    return (observation.odometry.T_odom_base @ T_base_laser).transform(scan.points())


def test_doctor_recognizes_the_lidar_without_a_command() -> None:
    with Emulator(plant(), lidar="ld19") as emulator:
        finding = examine(emulator.lidar.port.address, 500000)
        assert finding.fine
        assert finding.words.startswith("lidar of LDROBOT's LD series (LD06, LD19, STL-19P), ")
        assert finding.scan is not None
        assert to_walls(finding.scan.points() + np.array([0.16, 0.0])).max() < 0.01


def test_scans_delayed_by_the_link_are_not_new() -> None:
    """A pseudo-terminal keeps the first 16 kB that nobody reads: a second of old points."""
    with Emulator(plant(), lidar="ld19") as emulator:
        time.sleep(1.5)
        with HardwareRobot(load_scenario("corridor", emulator.port_settings), yes=True) as robot:
            seen = [robot.observe(5.0) for _ in range(5)]
    gaps = np.diff([one.scan.stamp for one in seen if one is not None])
    assert gaps.min() > 0.09


def test_one_lost_scan_of_a_slow_lidar_is_no_emergency() -> None:
    with Emulator(plant(), lidar="ld19") as emulator:
        assert isinstance(emulator.scanner, EmulatedLd19)
        emulator.scanner.rate = 5.0
        with HardwareRobot(load_scenario("corridor", emulator.port_settings), yes=True) as robot:
            for _ in range(3):
                assert robot.observe(5.0) is not None
            assert robot._devices is not None
            limits = robot._devices.limits
            assert limits["scan"] == pytest.approx(3.0 / 5.0, rel=0.05)
            assert limits["odometry"] == 0.3


FANS = st.builds(
    lambda beams, phase: Lidar(-pi + phase * 2.0 * pi / beams, 2.0 * pi / beams, beams, 0.02, 12.0, 0.1),
    st.integers(300, 800),
    st.floats(0.0, 1.0),
)


@given(FANS)
def test_the_view_of_a_turn_has_the_nominal_fan(fan: Lidar) -> None:
    scan = LaserScan(0.0, fan.angle_min, fan.angle_increment, 0.02, 12.0, 3.0 + np.cos(fan.angles))
    view = scan_array(scan, LD19.lidar)
    assert view.shape == (450,)
    step = max(fan.angle_increment, LD19.lidar.angle_increment)
    assert np.abs(view - (3.0 + np.cos(LD19.lidar.angles))).max() <= step


@pytest.mark.parametrize("model", LIDARS)
def test_the_view_of_the_nominal_fan_is_the_scan(model: str) -> None:
    lidar = LIDARS[model].lidar
    assert nearest_beams(lidar, lidar).tolist() == list(range(lidar.beams))


def test_a_view_beyond_the_scan_reads_no_echo() -> None:
    urg, turn = LIDARS["urg04lx"].lidar, LD19.lidar
    scan = LaserScan(0.0, urg.angle_min, urg.angle_increment, 0.06, 4.0, np.ones(urg.beams))
    view = scan_array(scan, turn)
    inside = (turn.angles > urg.angle_min) & (turn.angles < urg.angle_max)
    assert (view[inside] == 1.0).all()
    beyond = (turn.angles < urg.angle_min - 0.02) | (turn.angles > urg.angle_max + 0.02)
    assert (view[beyond] == 12.0).all()


def test_an_environment_keeps_its_fan() -> None:
    with P3DXEnv("cluttered_room", ["lidar.model=ld19", "physics.engine=plan"]) as env:
        seen, info = env.reset(seed=0)
        counts = set()
        for _ in range(5):
            assert env.observation_space.contains(seen)
            assert seen["scan"].shape == (450,)
            counts.add(len(info["observation"].scan.ranges))
            seen, *_, info = env.step(np.array([0.3, 0.5], np.float32))
    assert len(counts) > 1


def test_simulated_turns_vary_and_repeat() -> None:
    def ranges() -> list[FloatArray]:
        with SimRobot(load_scenario("cluttered_room", ["lidar.model=ld19"]), seed=3) as robot:
            seen = [robot.observe() for _ in range(6)]
        return [one.scan.ranges for one in seen if one is not None]

    first, again = ranges(), ranges()
    assert [one.tobytes() for one in first] == [one.tobytes() for one in again]
    assert len({len(one) for one in first}) > 1
    assert all(abs(len(one) - 450) <= 5 for one in first)


def test_simulated_noise_is_that_of_the_data_sheet() -> None:
    settings = ["lidar.model=ld19", "lidar.noise=datasheet", "lidar.rolling=false"]
    with (
        SimRobot(load_scenario("corridor", settings), seed=0) as noisy,
        SimRobot(load_scenario("corridor", [*settings[:1], "lidar.noise=none", settings[2]]), seed=0) as exact,
    ):
        pairs = [(noisy.observe(), exact.observe()) for _ in range(8)]
    seen = [(a.scan.ranges, b.scan.ranges) for a, b in pairs if a is not None and b is not None]
    measured, true = (np.concatenate(ranges) for ranges in zip(*seen, strict=True))
    both = np.isfinite(measured) & np.isfinite(true)
    assert np.std(measured[both] - true[both]) == pytest.approx(0.010, rel=0.1)


def test_a_corridor_is_mapped_with_the_lidar(tmp_path: Path) -> None:
    scenario = load_scenario("corridor", ["lidar.model=ld19", "physics.engine=plan", "duration=15"])
    metrics = scenario_experiment(scenario).run(tmp_path, console=Terminal(quiet=True), pictures=False).metrics
    assert metrics["scans"] == 150
    assert metrics["ate_rmse_m"] < 0.02
    assert metrics["heading_max_abs_deg"] < 0.6
    assert metrics["wall_precision"] > 0.95
