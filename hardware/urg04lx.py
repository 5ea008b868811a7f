"""The Hokuyo URG-04LX on its serial line."""

import logging
import threading
import time
from collections import deque
from dataclasses import replace
from math import inf
from typing import Final

import numpy as np

from hardware.scip.partial_scans import partial_scans
from hardware.scip.reply import Reply, find_reply
from hardware.scip.scan_data import ScanData
from hardware.scip.status import is_ok, status_meaning
from hardware.scip.time_stamp import SensorClock
from hardware.scip_session import RawAnswer, ScipLine, choose_request, connect_lidar, identify, stop_scans
from hardware.serial_port import SerialPort, backoff
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.scan import LaserScan
from slam.scenario.hardware_config import HardwareConfig

_LOG: Final = logging.getLogger("hopslam.urg04lx")
_POLL: Final = 0.1
"""Seconds after which the thread checks whether it should end."""
_SILENCE: Final = 1.5
"""Seconds without a scan after which the sensor is opened anew."""
_KEPT: Final = 4
"""Scans that wait for ``take``; older ones are dropped."""


class Urg04lx:
    """Opened when made: the sensor is found, and scans come from then on.

    A thread reads them; it opens the port again when it is lost, and the sensor when it falls silent. ``range_max`` is
    the reach that scans are cut to, metres. RobotError when no sensor answers.
    """

    def __init__(self, config: HardwareConfig, range_max: float, wire: WireSession | None = None) -> None:
        self._config = config
        self._wire = wire or WireSession()
        self._range_max = range_max
        self._closing = threading.Event()
        self._news = threading.Condition()
        self._scans: deque[LaserScan] = deque(maxlen=_KEPT)
        self.scanned_at = time.monotonic()
        self.trouble: str | None = None
        self._line = self._connect()
        self._thread = threading.Thread(target=self._serve, name="urg04lx", daemon=True)
        self._thread.start()

    def take(self, timeout: float, newest: bool = False) -> LaserScan | None:
        """Return the next scan, oldest first, or the ``newest`` of those that wait, stamped in ``time.monotonic``.

        None when none comes within ``timeout`` seconds.
        """
        with self._news:
            self._news.wait_for(lambda: self._scans, timeout)
            while newest and len(self._scans) > 1:
                self._scans.popleft()
            return self._scans.popleft() if self._scans else None

    def close(self) -> None:
        """Switch the laser off, and let go of the sensor; closing twice is allowed."""
        if not self._closing.is_set():
            self._closing.set()
            self._thread.join()

    def _connect(self) -> ScipLine:
        line = ScipLine(SerialPort(self._config.lidar_port, self._config.lidar_baud, self._wire), self._closing)
        try:
            connect_lidar(line, self._config.lidar_baud)
            _, self._parameters = identify(line)
            self._request = choose_request(self._parameters, line.port.baud if line.port.has_baud else None)
            line.ask_until_answered(self._request.encode())
        except BaseException:
            line.port.close()
            raise
        self._clock = SensorClock(self._parameters.step_time * (self._parameters.last + 1))
        return line

    def _serve(self) -> None:
        while not self._closing.is_set():
            try:
                self._listen()
            except RobotError as error:
                self._reconnect(str(error))
        stop_scans(self._line)
        self._line.port.close()

    def _listen(self) -> None:
        """Take scans until the driver is closed; RobotError when there are no more."""
        last_scan_at = time.monotonic()
        while not self._closing.is_set():
            for frame in self._line.receive(_POLL):
                if self._take(frame):
                    last_scan_at = frame.ended
            if time.monotonic() - last_scan_at > _SILENCE:
                raise RobotError(f"{self._config.lidar_port}: the lidar sends no scans any more")

    def _take(self, frame: RawAnswer) -> bool:
        """Take the scans in a frame; False where it held none."""
        found = [data for data in partial_scans(frame.lines, self._parameters.range_max) if self._is_ours(data)]
        taken = [self._take_scan(data, frame) for data in found]
        if not found:
            self._require_fine(find_reply(frame.lines))
        return any(taken)

    def _is_ours(self, data: ScanData) -> bool:
        return replace(data.request, scans=0) == self._request

    def _take_scan(self, data: ScanData, frame: RawAnswer) -> bool:
        # Of an answer that stood behind the remains of another nobody knows when it began to come.
        whole = frame.lines[0] == data.request.encode().encode()
        if data.time is None or not (whole or self._clock.running):
            return False
        scan = self._scan(data, data.time, frame.began if whole else inf)
        with self._news:
            self._scans.append(scan)
            self.scanned_at, self.trouble = frame.ended, None
            self._news.notify_all()
        return True

    def _require_fine(self, reply: Reply | None) -> None:
        """Raise RobotError where an answer to our request says why there are no scans."""
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
            scan_time=lidar.scan_time * (1 + self._request.interval),
        )

    def _reconnect(self, reason: str) -> None:
        """Try again and again, and ever less often, until the sensor answers or the driver is closed."""
        self.trouble = reason
        _LOG.warning("%s", reason)
        self._line.port.close()
        for _ in backoff(self._closing):
            try:
                self._line = self._connect()
            except RobotError as error:
                self.trouble = str(error)
                continue
            _LOG.warning("%s: the lidar is back", self._config.lidar_port)
            return
