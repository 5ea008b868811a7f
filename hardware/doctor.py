"""Examines serial ports: which device answers there, or what keeps it from answering."""

import os
import threading
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from serial.tools.list_ports import comports

from hardware import DecodeError
from hardware.arcos.model import units_of
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos_session import ArcosLine, connect_robot, disconnect_robot, read_config
from hardware.scip.scan_data import ScanData, decode_scan
from hardware.scip_session import ScipLine, connect_lidar, identify, stop_scans
from hardware.serial_port import SerialPort
from slam.errors import RobotError
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Finding:
    """The device at a port, in words, and a scan where it is a lidar."""

    port: str
    words: str
    scan: LaserScan | None = None


def ports() -> list[str]:
    """List the serial ports of this machine."""
    return sorted(port.device for port in comports())


def examine(port: str, lidar_baud: int) -> Finding:
    """Find out which device answers at this port.

    Nothing moves: the robot is opened, read and closed, its motors without power.
    """
    if "://" not in port and Path(port).exists() and not os.access(port, os.R_OK | os.W_OK):
        return Finding(port, "not permitted; run: sudo usermod -aG dialout $USER, then log out and in again")
    reasons = []
    for look in (_lidar, _robot):
        try:
            return look(port, lidar_baud)
        except RobotError as error:
            reasons.append(str(error).removeprefix(f"{port}: "))
    return Finding(port, reasons[0] if len(set(reasons)) == 1 else "neither a SCIP lidar nor an ARCOS robot answers")


def _lidar(port: str, baud: int) -> Finding:
    line = ScipLine(SerialPort(port, baud), threading.Event())
    with closing(line.port):
        connect_lidar(line, baud)
        version, parameters = identify(line)
        line.ask_until_answered("BM")
        data = _latest(line, parameters.first, parameters.last)
        stop_scans(line)
    lidar = parameters.lidar
    scan = LaserScan(0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, data.ranges)
    words = (
        f"lidar {version.product}, firmware {version.firmware}, serial number {version.serial_number}, "
        f"{version.protocol}, {1.0 / lidar.scan_time:g} scans a second of {lidar.beams} beams, "
        f"{int(scan.echoes.sum())} with an echo"
    )
    return Finding(port, words, scan)


def _latest(line: ScipLine, first: int, last: int) -> ScanData:
    for _ in range(3):
        with suppress(DecodeError):
            return decode_scan(line.ask_until_answered(f"GD{first:04d}{last:04d}01"))
    raise RobotError(f"{line.port.url}: the lidar's scans come damaged; look at its cable")


def _robot(port: str, _: int) -> Finding:
    line = ArcosLine(SerialPort(port, 9600), threading.Event())
    with closing(line.port):
        identity = connect_robot(line)
        config = read_config(line)
        report = line.wait_for(is_sip)
        disconnect_robot(line)
    battery, units = "unknown", units_of(identity.subclass)
    if report is not None and units is not None:
        with suppress(DecodeError):
            battery = f"{Sip.decode(report, units).battery:.1f} V"
    words = (
        f"robot {identity.name}, class {identity.robot_class}, subclass {identity.subclass}, "
        f"firmware {config.firmware or 'unknown'}, battery {battery}, watchdog {config.watchdog:g} s"
    )
    return Finding(port, words)
