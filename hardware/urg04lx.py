"""The Hokuyo URG-04LX on its serial line."""

import threading
import time
from dataclasses import replace
from typing import Final

import numpy as np

from hardware.device_thread import DeviceThread
from hardware.scan_queue import ScanQueue
from hardware.scip.partial_scans import partial_scans
from hardware.scip.reply import Reply, find_reply
from hardware.scip.scan_data import ScanData
from hardware.scip.status import is_ok, status_meaning
from hardware.scip.time_stamp import TIME_WRAP
from hardware.scip_line import RawAnswer, ScipLine
from hardware.scip_scans import choose_request, reason_for_silence, switch_laser_on
from hardware.scip_session import connect_lidar, identify, stop_scans
from hardware.sensor_clock import SensorClock
from hardware.serial_port import PortLost, SerialPort
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.lidars import LidarModel
from slam.scan import LaserScan
from slam.scenario.hardware_config import HardwareConfig

_POLL: Final = 0.1
"""Seconds after which the thread checks whether it should end."""
_SILENCE: Final = 1.5
_LOST_SCANS: Final = 5
"""The sensor is opened again after _LOST_SCANS periods without a scan, but not before _SILENCE seconds."""


class Urg04lx:
    """The constructor finds the sensor and starts its scans.

    A thread reads them; it opens the port again when it is lost, and the sensor when it falls silent. Ranges beyond
    those of ``model`` are removed. Once ``leaving`` is set, attempts to connect are given up. RobotError if no sensor
    answers.
    """

    def __init__(self, config: HardwareConfig, model: LidarModel, leaving: threading.Event, wire: WireSession) -> None:
        self._config = config
        self._wire = wire
        self._range_max = model.lidar.range_max
        self._leaving = leaving
        self.scans = ScanQueue()
        self._clock = SensorClock(TIME_WRAP)
        self._thread = DeviceThread("lidar", self._serve, self._lose, self._connect, leaving)
        self._connect()
        self._thread.start()

    @property
    def trouble(self) -> str | None:
        """Reason why no scans arrive; None if they do."""
        return self._thread.trouble

    @property
    def period(self) -> float:
        """Seconds from scan to scan: turns are left out if the line is too slow for every turn."""
        return self._parameters.scan_time * (1 + self._request.interval)

    def close(self) -> None:
        """Switch the laser off, and close the port; closing twice is allowed."""
        self._leaving.set()
        self._thread.close()
        stop_scans(self._line)
        self._line.port.close()

    def _connect(self) -> None:
        line = ScipLine(SerialPort(self._config.lidar_port, self._config.lidar_baud, self._wire), self._leaving)
        try:
            connect_lidar(line, self._config.lidar_baud)
            _, self._parameters = identify(line)
            switch_laser_on(line)
            self._request = choose_request(self._parameters, line.port.baud if line.port.has_baud else None)
            line.ask_until_answered(self._request.encode())
            end_of_fan = self._parameters.step_time * (self._parameters.last + 1)
            self._clock = SensorClock(TIME_WRAP, end_of_fan, after=self._clock.latest)
            self._line, self._last_scan_at = line, time.monotonic()
            while not self._clock.running:
                self._give_up_when_leaving()
                self._serve()
        except BaseException:
            line.port.close()
            raise

    def _serve(self) -> None:
        """Take the scans of a short time; RobotError if no more arrive."""
        for frame in self._line.receive(_POLL):
            if self._take(frame):
                self._last_scan_at = frame.ended
        if time.monotonic() - self._last_scan_at > max(_SILENCE, _LOST_SCANS * self.period):
            reason = reason_for_silence(self._line, self._parameters)
            words = "the lidar sends no scans any more" if self._clock.running else "the lidar sends no scans"
            raise RobotError(f"{self._config.lidar_port}: {words}{f': {reason}' if reason else ''}")

    def _give_up_when_leaving(self) -> None:
        if self._leaving.is_set():
            raise PortLost(f"{self._config.lidar_port}: given up")

    def _lose(self) -> None:
        self._line.port.close()

    def _take(self, frame: RawAnswer) -> bool:
        """Take the scans in a frame; False if it held none."""
        found = [data for data in partial_scans(frame.lines, self._parameters.range_max) if self._is_ours(data)]
        taken = [self._take_scan(data, frame) for data in found]
        if not found:
            self._require_fine(find_reply(frame.lines))
        return any(taken)

    def _is_ours(self, data: ScanData) -> bool:
        return replace(data.request, scans=0) == self._request

    def _take_scan(self, data: ScanData, frame: RawAnswer) -> bool:
        """Keep a scan; False if its time cannot be known."""
        # the time of the first byte is unknown if remains of another answer come first
        whole = frame.lines[0] == data.request.encode().encode()
        if data.time is None or not (whole or self._clock.running):
            return False
        scan = self._scan(data, data.time, frame.began if whole else frame.ended)
        self._thread.trouble = None
        if self._clock.settled:
            self.scans.put(scan, frame.ended)
        return True

    def _require_fine(self, reply: Reply | None) -> None:
        """Raise RobotError if an answer to our request says why there are no scans."""
        if reply is not None and reply.echo == self._request.encode() and not is_ok(reply.status):
            why = status_meaning(reply.echo, reply.status)
            raise RobotError(f"{self._config.lidar_port}: the lidar stopped: status {reply.status}, {why}")

    def _scan(self, data: ScanData, sensor_time: float, arrival: float) -> LaserScan:
        """Make the scan, stamped at its first beam: the sensor stamps step 0."""
        lidar, step_time = self._parameters.lidar, self._parameters.step_time
        return LaserScan(
            stamp=self._clock.host_time(sensor_time, arrival) + self._parameters.first * step_time,
            angle_min=lidar.angle_min,
            angle_increment=lidar.angle_increment,
            range_min=lidar.range_min,
            range_max=self._range_max,
            ranges=np.where(data.ranges > self._range_max, np.inf, data.ranges),
            time_increment=step_time,
            scan_time=self.period,
        )
