"""The drivers against emulated devices in real time, with faults."""

import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.arcos.model import P3DX_SH
from hardware.arcos.sip import Sip
from hardware.base_odometry import PositionOdometry, WheelScales
from hardware.emulator.emulator import Emulator
from hardware.emulator.p3dx import FACTORY_CONFIG
from hardware.emulator.ports import TcpPort
from hardware.emulator.pty_port import PtyPort
from hardware.emulator.serial_line import LineNoise
from hardware.odometry_history import OdometryHistory
from hardware.robot import HardwareRobot
from hardware.sensor_clock import SensorClock
from hardware.serial_port import PortLost, SerialPort
from sim.plant import SimPlant
from slam.errors import RobotError, RobotTimeout, ScenarioError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.robot import Observation
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario
from tests.rooms import room_plant

FORWARD = Twist2D(0.3, 0.0)
PATIENCE = 20.0
"""Seconds after which a test fails if its condition is still false: many, for a busy machine."""


def plant() -> SimPlant:
    return room_plant((-2.0, 3.5), (-2.0, 2.0), 0.16)


def scenario(emulator: Emulator, *settings: str) -> Scenario:
    return load_scenario("corridor", [*emulator.port_settings, *settings])


def wait_until(condition: Callable[[], object]) -> None:
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, "it never came true"
        time.sleep(0.01)


def drive_until(robot: HardwareRobot, condition: Callable[[Observation | None], object]) -> None:
    """Observe and drive, as a run does, until the condition is true; a time-out is not the end."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            observation = robot.observe(0.5)
        except RobotTimeout:
            observation = None
        robot.drive(FORWARD)
        if condition(observation):
            return
        assert time.monotonic() < until, "it never came true"


@contextmanager
def emulated_robot(*settings: str, **options: bool) -> Iterator[tuple[Emulator, HardwareRobot]]:
    with (
        Emulator(plant(), paced=False) as emulator,
        HardwareRobot(scenario(emulator, *settings), **({"yes": True} | options)) as robot,
    ):
        yield emulator, robot


def still(emulator: Emulator) -> bool:
    return not emulator.p3dx.motors.moving


@pytest.fixture(autouse=True)
def quiet(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)


def test_consecutive_faults_are_survived(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Each fault stops the robot, which names the reason; once the fault is repaired, the run goes on."""
    links = PtyPort(tmp_path / "p3dx"), PtyPort(tmp_path / "urg04lx")
    with (
        Emulator(plant(), *links, robot_config=replace(FACTORY_CONFIG, watchdog=0.8)) as emulator,
        HardwareRobot(scenario(emulator), yes=True) as robot,
    ):

        def goes() -> None:
            drive_until(robot, lambda observation: observation is not None and not still(emulator))

        goes()
        wait_until(lambda: still(emulator))  # nobody commands
        assert "no command" in str(robot.trouble)
        goes()
        emulator.do(lambda: emulator.p3dx.motors.press_e_stop(True))
        drive_until(robot, lambda _: "emergency stop" in str(robot.trouble) and still(emulator))
        assert robot.drive(FORWARD) == Twist2D()
        emulator.do(lambda: emulator.p3dx.motors.press_e_stop(False))
        goes()
        emulator.do(lambda: emulator.p3dx.motors.enable(False))
        drive_until(robot, lambda _: "switched off" in str(robot.trouble) and still(emulator))
        emulator.do(lambda: emulator.p3dx.motors.enable(True))
        goes()
        emulator.do(emulator.lidar.unplug)
        drive_until(robot, lambda seen: seen is None and still(emulator))
        assert "urg04lx" in str(robot.trouble)
        emulator.do(emulator.lidar.port.open)
        goes()
        emulator.do(lambda: emulator.lidar.stall(emulator.now + 0.8))
        drive_until(robot, lambda _: still(emulator))
        goes()
        emulator.do(emulator.robot.unplug)
        drive_until(robot, lambda _: "p3dx" in str(robot.trouble) and robot.drive(FORWARD) == Twist2D())
        wait_until(lambda: still(emulator))  # its own watchdog
        emulator.do(emulator.robot.port.open)
        goes()
    assert still(emulator)
    assert not emulator.urg04lx.laser
    assert not emulator.p3dx.open
    assert any("no command" in record.getMessage() for record in caplog.records)


def test_the_watchdog_stops_a_killed_programs_robot() -> None:
    script = """
import sys
from hardware.robot import HardwareRobot
from slam.odometry import Twist2D
from slam.scenario.file import load_scenario
with HardwareRobot(load_scenario("corridor", sys.argv[1:]), yes=True) as robot:
    while True:
        robot.observe()
        robot.drive(Twist2D(0.3, 0.0))
        print("driving", flush=True)
"""
    with Emulator(plant(), robot_config=replace(FACTORY_CONFIG, watchdog=0.8)) as emulator:

        def start() -> subprocess.Popen[str]:
            command = [sys.executable, "-c", script, *emulator.port_settings]
            program = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": "."})
            wait_until(lambda: not still(emulator))
            return program

        with start() as program:
            program.kill()
        assert emulator.p3dx.open
        assert emulator.urg04lx.laser
        wait_until(lambda: still(emulator))
        with start() as program:  # finds a robot left open, at another bit rate, and a stream left running
            program.send_signal(signal.SIGTERM)
            assert program.wait(PATIENCE) == 128 + signal.SIGTERM
        assert still(emulator) or not emulator.p3dx.motors.enabled
        assert not emulator.p3dx.open
        assert not emulator.urg04lx.laser


def test_a_robot_is_driven_over_tcp_by_wheel_speeds() -> None:
    with (
        Emulator(plant(), TcpPort(), TcpPort(), paced=False) as emulator,
        HardwareRobot(scenario(emulator, "hardware.drive_by=wheels", "hardware.odometry=encoders"), yes=True) as robot,
    ):
        sent = robot.drive(Twist2D(0.31, 0.2))
        assert sent != Twist2D(0.31, 0.2)
        assert sent.linear == pytest.approx(0.31, abs=0.01)
        drive_until(robot, lambda seen: seen and seen.odometry.T_odom_base.x > 0.05)


def test_a_dry_run_and_a_refusal_never_move() -> None:
    with emulated_robot(dry_run=True) as (emulator, robot):
        for _ in range(3):
            assert robot.observe() is not None
            assert robot.drive(FORWARD) == Twist2D()
        assert not emulator.p3dx.motors.enabled
    with emulated_robot(yes=False) as (emulator, robot):
        assert robot.drive(Twist2D()) == Twist2D()
        with pytest.raises(RobotError, match="nobody can be asked"):
            robot.drive(FORWARD)
        assert not emulator.p3dx.motors.enabled


def test_a_noisy_line_gives_no_wrong_range_and_no_hang() -> None:
    noise = LineNoise(bit_errors=1e-4, dropped=2e-5, duplicated=2e-5)
    truth = plant().ranges((np.arange(44, 726) - 384) * 2 * pi / 1024)
    with (
        Emulator(plant(), noise=noise, seed=3, paced=False) as emulator,
        HardwareRobot(scenario(emulator), yes=True) as robot,
    ):
        for _ in range(5):
            observation = robot.observe(PATIENCE)
            assert observation is not None
            came = ~np.isnan(observation.scan.ranges)
            assert came.mean() > 0.7
            assert observation.scan.ranges[came] == pytest.approx(truth[came], abs=6e-4)
            assert observation.odometry.T_odom_base == Pose2D()


def test_a_rs_232_lidar_is_found_at_its_own_bit_rate() -> None:
    with (
        Emulator(plant(), lidar_on_usb=False) as emulator,
        HardwareRobot(scenario(emulator), dry_run=True) as robot,
    ):
        assert robot.observe(PATIENCE) is not None
        assert emulator.urg04lx.baud == 500_000


def test_a_scenario_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"set lidar\.model=urg04lx"):
        HardwareRobot(load_scenario("paper_simulation"))
    with pytest.raises(PortLost, match="no such port"):
        SerialPort("/dev/there-is-none", 9600)
    with pytest.raises(RobotError, match="/dev/there-is-none"):
        HardwareRobot(load_scenario("corridor", ["hardware.lidar_port=/dev/there-is-none"])).__enter__()


def test_a_lost_port_is_reported_and_a_port_is_exclusive() -> None:
    far = PtyPort()
    port = SerialPort(far.address, 9600)
    with pytest.raises(PortLost, match="another program"):
        SerialPort(far.address, 9600)
    far.write(b"hello")
    assert port.read(PATIENCE) == b"hello"
    assert port.read(0.0) == b""
    far.close()
    with pytest.raises(PortLost, match="unplugged"):
        port.read(PATIENCE)
    port.close()
    port.close()
    loop = SerialPort("loop://", 9600)
    loop.write(b"hello")
    assert loop.read(PATIENCE) == b"hello"


def test_an_emulator_that_is_not_a_robot_is_named(tmp_path: Path) -> None:
    """Two ports mixed up: the lidar's driver finds no lidar, and names the port."""
    with Emulator(plant(), TcpPort(), TcpPort(), paced=False) as emulator:
        swapped = [f"robot_port={emulator.lidar.port.address}", f"lidar_port={emulator.robot.port.address}"]
        wrong = load_scenario("corridor", [f"hardware.{setting}" for setting in swapped])
        with pytest.raises(RobotError, match="no SCIP sensor answers"):
            HardwareRobot(wrong).__enter__()


@given(st.floats(-300e-6, 300e-6), st.integers(0, 2**32))
def test_a_sensor_clock_is_followed_through_drift_and_wrap(drift: float, seed: int) -> None:
    wrap, start, delay = 100.0, 97.0, 0.07
    rng = np.random.default_rng(seed)
    clock = SensorClock(wrap, delay)
    errors = []
    for k in range(3000):
        at = 1000.0 + 0.1 * k
        sensor_time = round(start + (at - 1000.0) * (1.0 + drift), 3) % wrap
        arrival = at + delay + rng.exponential(0.002)
        errors.append(clock.host_time(sensor_time, arrival) - at)
    assert np.abs(errors[50:]).max() < 0.004


@given(st.lists(st.floats(0.0, 2.0), min_size=2, max_size=40), st.floats(0.0, 5.0))
def test_sensor_times_increase_despite_link_delays(delays: list[float], start: float) -> None:
    clock = SensorClock(5.0, 0.05, after=100.0)
    before = 100.0
    for k, delay in enumerate(delays):
        at = 101.0 + 0.1 * k
        stamp = clock.host_time(round(start + 0.1 * k, 3) % 5.0, at + 0.05 + delay)
        assert stamp > before
        assert not clock.settled or stamp <= at + delay + 1e-9
        before = stamp


def test_delayed_scans_do_not_set_the_clock() -> None:
    clock = SensorClock(16777.216, 0.07)
    arrivals = [0.42, 0.42, 0.42, 0.42, 0.47, 0.57]  # 0.35 s late at first, then 0.07 s, the usual delay
    stamps = [clock.host_time(0.1 * k, at) for k, at in enumerate(arrivals[:4])]
    assert stamps == sorted(set(stamps))
    assert not clock.settled
    stamps = [clock.host_time(0.1 * k, arrivals[k]) for k in (4, 5)]
    assert stamps == pytest.approx([0.4, 0.5], abs=1e-3)
    assert clock.settled


def test_a_track_interpolates_and_extrapolates() -> None:
    track, twist = OdometryHistory(), Twist2D(0.5, 0.2)
    for k in range(200):
        track.add(0.1 * k, twist.motion(0.1 * k), twist)
    for stamp in (18.0, 18.03, 19.99):
        assert track.covers(stamp)
        assert track.pose_at(stamp).distance(twist.motion(stamp)) < 1e-9
    assert not track.covers(1.0)
    assert not track.covers(20.5)
    odometry = track.between(18.02, 18.08)
    assert odometry.twist.linear == pytest.approx(0.5)
    assert odometry.twist.angular == pytest.approx(0.2)


def test_an_impossible_step_is_left_out() -> None:
    track = OdometryHistory()
    odometry = PositionOdometry(P3DX_SH, WheelScales(P3DX_SH.half_track), track)
    places = [0.0, 0.03, 0.30, 0.09, 0.12]
    taken = [odometry.add(0.1 * k, Sip(x=x, left=0.3, right=0.3)) for k, x in enumerate(places)]
    assert taken == [True, True, False, True, True]
    assert track.last is not None
    assert track.last[1].x == pytest.approx(0.12)
    for k in range(5, 15):  # the robot starts again at another place
        odometry.add(0.1 * k, Sip(x=20.0, left=0.0, right=0.0))
    assert track.last[1].x == pytest.approx(0.12)
    assert track.last[0] == pytest.approx(1.4)


def test_closing_while_the_devices_are_gone_does_not_hang() -> None:
    with emulated_robot() as (emulator, robot):
        emulator.do(emulator.lidar.unplug)
        emulator.do(emulator.robot.unplug)
        wait_until(lambda: robot.trouble)
    assert threading.active_count() < 20
    with pytest.raises(RobotError, match="closed"):
        robot.observe()
