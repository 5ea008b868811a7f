"""LDROBOT's LD19, LD06 and STL-19P on their serial line."""

import threading
import time
from typing import Final

import numpy as np

from hardware.device_thread import DeviceThread
from hardware.ldrobot import BAUD, SIZE, TIME_WRAP, LdDecoder
from hardware.lidars.ld_turns import Turn, TurnCollector
from hardware.scan_queue import ScanQueue
from hardware.sensor_clock import SensorClock
from hardware.serial_port import BITS_PER_BYTE, NoDevice, PortLost, SerialPort
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.lidars import LidarModel
from slam.scenario.hardware_config import HardwareConfig

_POLL: Final = 0.1
"""Seconds after which the thread checks whether it should end."""
_FIRST_PACKET: Final = 2.0
"""Seconds for a packet to come: the sensor needs 0.7 s after it gets power (LD19 Development Manual)."""
_MIN_SILENCE: Final = 1.5
_LOST_SCANS: Final = 5
"""The sensor is opened again after _LOST_SCANS turns without a scan, but not before _MIN_SILENCE seconds."""
_FEWEST: Final = 0.75
"""Share of the beams of a turn that must arrive for a valid scan."""
_SENDING: Final = SIZE * BITS_PER_BYTE / BAUD
"""Least seconds that a packet takes on the line."""


class Ld19:
    """Opened by the constructor, which waits for packets; from then on it makes scans.

    A thread reads them; it opens the port again when it is lost, or falls silent. Scans begin and end behind the robot;
    the sensor turns clockwise, so that the time decreases from beam to beam. Once ``leaving`` is set, attempts to
    connect are given up. RobotError if no valid packet arrives.
    """

    def __init__(self, config: HardwareConfig, model: LidarModel, leaving: threading.Event, wire: WireSession) -> None:
        self._port_name, self._lidar = config.lidar_port, model.lidar
        self._leaving, self._wire = leaving, wire
        self.scans = ScanQueue()
        self._clock = SensorClock(TIME_WRAP, _SENDING)
        self._turn = TurnCollector()
        self.period = self._lidar.scan_time
        """Seconds from scan to scan."""
        self._connect()
        self._thread = DeviceThread("lidar", self._serve, self._lose, self._connect, leaving)
        self._thread.start()

    @property
    def trouble(self) -> str | None:
        """Reason why no scans arrive; None if they do."""
        return self._thread.trouble

    def close(self) -> None:
        """Close the port; the sensor keeps turning; closing twice is allowed."""
        self._leaving.set()
        self._thread.close()
        self._port.close()

    def _connect(self) -> None:
        self._port = SerialPort(self._port_name, BAUD, self._wire)
        self._decoder, self._turn = LdDecoder(), TurnCollector()
        self._clock = SensorClock(TIME_WRAP, _SENDING, after=self._clock.latest)
        until = time.monotonic() + _FIRST_PACKET
        try:
            while not self._receive():
                if self._leaving.is_set():
                    raise PortLost(f"{self._port_name}: given up")
                if time.monotonic() > until:
                    tip = "is it powered, its PWM line at ground, and this the right port?"
                    raise NoDevice(f"{self._port_name}: no packets of an LD19 come at {BAUD} baud; {tip}")
        except BaseException:
            self._port.close()
            raise
        self._last_scan_at = time.monotonic()

    def _lose(self) -> None:
        self._port.close()

    def _serve(self) -> None:
        """Take the packets of a short time; RobotError if no more scans arrive."""
        self._receive()
        if time.monotonic() - self._last_scan_at > max(_MIN_SILENCE, _LOST_SCANS * self.period):
            raise RobotError(f"{self._port_name}: the lidar sends no scans any more")

    def _receive(self) -> int:
        """Take the packets that have arrived, and return their number."""
        packets = self._decoder.feed(self._port.read(_POLL))
        now = time.monotonic()
        for packet in packets:
            whole = self._turn.add(packet, self._clock.host_time(packet.time, now))
            if whole is not None:
                self._keep(whole, now)
        return len(packets)

    def _keep(self, turn: Turn, now: float) -> None:
        """Keep a whole turn as a scan, unless much of it is missing or its time is unknown."""
        scan = turn.scan(self._lidar.range_min, self._lidar.range_max)
        self._last_scan_at, self.period = now, scan.scan_time
        if self._clock.settled and np.isnan(scan.ranges).mean() <= 1.0 - _FEWEST:
            self._thread.trouble = None
            self.scans.put(scan, now)
