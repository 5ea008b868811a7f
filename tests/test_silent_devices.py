"""Devices that pause, fall silent or make the driver fail: the messages, and the time limits."""

import logging
import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from hardware.arcos_line import ArcosLine
from hardware.device_thread import DeviceThread
from hardware.emulator.pty_port import PtyPort
from hardware.robot import HardwareRobot
from hardware.scip_line import ScipLine
from hardware.serial_port import PortLost, SerialPort
from slam.errors import RobotError
from slam.scenario.file import load_scenario

SYNC0 = bytes.fromhex("FAFB03000000")


class Clumsy:
    """A driver that fails in three ways, one after another."""

    def __init__(self) -> None:
        self.failures: list[Exception] = [ZeroDivisionError("in a codec"), PortLost("unplugged"), KeyError("again")]
        self.connections = self.losses = 0
        self.well = threading.Event()
        self.thread = DeviceThread("lidar", self.serve, self.lose, self.connect, threading.Event())

    def serve(self) -> None:
        if self.failures:
            raise self.failures.pop(0)
        self.thread.trouble = None
        self.well.set()

    def lose(self) -> None:
        self.losses += 1

    def connect(self) -> None:
        self.connections += 1
        if self.connections == 2:
            raise RobotError("nobody answers")


def test_a_failed_driver_is_reported_and_restarted(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    driver = Clumsy()
    driver.thread.start()
    assert driver.well.wait(20.0)
    driver.thread.close()
    assert (driver.losses, driver.connections) == (3, 4)
    said = [record.getMessage() for record in caplog.records]
    assert "starts again: ZeroDivisionError: in a codec (test_silent_devices.py, line" in said[0]
    assert said[1:3] == ["the lidar is back", "unplugged"]


@contextmanager
def pausing_server(answer: bytes, pause: float) -> Iterator[str]:
    """A device behind a network that answers every command, with a pause in the middle."""

    def serve() -> None:
        client, _ = server.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with client:
            while client.recv(100):
                client.sendall(answer[: len(answer) // 2])
                time.sleep(pause)
                client.sendall(answer[len(answer) // 2 :])

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"socket://127.0.0.1:{server.getsockname()[1]}"
    thread.join()


def test_a_pause_within_an_answer_loses_no_byte() -> None:
    with pausing_server(b"QT\n00P\n\n", 0.1) as url:
        lidar = ScipLine(SerialPort(url, 19200), threading.Event())
        assert lidar.ask("QT", 5.0) is not None
        lidar.port.close()
    with pausing_server(SYNC0, 0.1) as url:
        robot = ArcosLine(SerialPort(url, 9600), threading.Event())
        robot.port.write(SYNC0)
        assert robot.wait_for(lambda data: data == b"\0", 5.0) is not None
        robot.port.close()


def test_an_ending_program_does_not_wait_for_a_device() -> None:
    ports = PtyPort(), PtyPort()
    settings = [f"hardware.lidar_port={ports[0].address}", f"hardware.robot_port={ports[1].address}"]
    before = signal.signal(signal.SIGTERM, lambda *_: None)  # a run handles it after the step
    ending = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGTERM])
    try:
        robot = HardwareRobot(load_scenario("corridor", settings))
        ending.start()
        with pytest.raises(RobotError, match="given up: the program got SIGTERM"):
            robot.__enter__()
    finally:
        ending.join()
        signal.signal(signal.SIGTERM, before)
        for port in ports:
            port.close()
