"""Examines a lidar that speaks SCIP: its model, its state, and one scan."""

import threading
from contextlib import closing, suppress
from dataclasses import replace
from typing import Final

from hardware import DecodeError
from hardware.doctor.finding import Finding
from hardware.scip.commands import ScanRequest
from hardware.scip.information import SensorParameters, SensorState
from hardware.scip.reply import Reply
from hardware.scip.scan_data import ScanData, decode_scan
from hardware.scip.status import is_ok
from hardware.scip_line import ScipLine
from hardware.scip_scans import switch_laser_on
from hardware.scip_session import connect_lidar, identify, stop_scans
from hardware.serial_port import SerialPort
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.scan import LaserScan

_WORKS: Final = "Sensor works well"
"""States that a lidar without a fault reports (C-42-03320B, II)."""


def examine_scip_lidar(port: str, baud: int, wire: WireSession | None) -> Finding:
    """Find the lidar, ask for its model, and take a scan; NoDevice if none answers."""
    line = ScipLine(SerialPort(port, baud, wire), threading.Event())
    with closing(line.port):
        connect_lidar(line, baud)
        try:
            version, parameters = identify(line)
            faults, scan = _try_laser(line, parameters)
        finally:
            stop_scans(line)
    lidar = parameters.lidar
    words = (
        f"lidar {version.product}, firmware {version.firmware}, serial number {version.serial_number}, "
        f"{version.protocol}, {1.0 / lidar.scan_time:g} scans a second of {lidar.beams} beams"
    )
    if scan is not None:
        words += f", {int(scan.echoes.sum())} with an echo"
    return Finding(port, words, faults=tuple(faults), scan=scan)


def _try_laser(line: ScipLine, parameters: SensorParameters) -> tuple[list[str], LaserScan | None]:
    """Ask for the state, switch the laser on and take a scan.

    Return the faults that the lidar reported, and the scan; None without one.
    """
    faults: list[str] = []
    with suppress(RobotError, DecodeError):  # not every sensor has II
        condition = SensorState.decode(line.ask_until_answered("II")).condition
        if not condition.startswith(_WORKS):
            faults.append(f'the lidar reports "{condition}"; switch it off and on, and see its manual')
    try:
        switch_laser_on(line)
        data = _latest(line, parameters)
    except RobotError as refusal:
        said = str(refusal).removeprefix(f"{line.port.url}: ")
        return [*faults, f"{said}; switch it off and on; if the message comes again, it needs repair"], None
    lidar = parameters.lidar
    fan = (lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max)
    return faults, LaserScan(0.0, *fan, data.ranges)


def _latest(line: ScipLine, parameters: SensorParameters) -> ScanData:
    """Ask for one scan, by MD if the sensor does not have GD."""
    single = ScanRequest("GD", parameters.first, parameters.last)
    for _ in range(3):
        with suppress(DecodeError):
            reply = line.ask(single.encode())
            if reply is not None and is_ok(reply.status):
                return decode_scan(reply)
            if reply is not None and reply.status.isdigit():
                line.ask_until_answered(single.encode())  # raises the error of the sensor
            return decode_scan(_streamed(line, parameters))
    raise RobotError(f"{line.port.url}: scans of the lidar arrive damaged; check its cable")


def _streamed(line: ScipLine, parameters: SensorParameters) -> Reply:
    request = ScanRequest("MD", parameters.first, parameters.last, scans=1)
    line.ask_until_answered(request.encode())
    reply = line.wait_for(replace(request, scans=0).encode(), 10.0 * parameters.scan_time)
    if reply is None:
        raise RobotError(f"{line.port.url}: the lidar obeys {request.encode()}, but sends no scan")
    return reply
