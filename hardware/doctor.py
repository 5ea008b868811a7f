"""Examines serial ports: which device answers there, what it says of itself, and what keeps it from driving."""

import threading
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from typing import Final

from hardware import DecodeError
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import UNITS, Identity, units_of
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos_line import ArcosLine
from hardware.arcos_session import connect_robot, disconnect_robot, read_config
from hardware.scip.commands import ScanRequest
from hardware.scip.information import SensorParameters, SensorState
from hardware.scip.reply import Reply
from hardware.scip.scan_data import ScanData, decode_scan
from hardware.scip.status import is_ok
from hardware.scip_line import ScipLine
from hardware.scip_scans import switch_laser_on
from hardware.scip_session import connect_lidar, identify, stop_scans
from hardware.serial_port import NoDevice, PortLost, SerialPort
from hardware.usb_serial import latency_timer
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.scan import LaserScan

_FIRST_ROBOT_BAUD: Final = 9600
_LONGEST_WATCHDOG: Final = 2.0
"""Seconds, the default of ``hardware.max_watchdog``."""
_WORKS: Final = "Sensor works well"
"""Words of a lidar without a fault (C-42-03320B, II)."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found at a port, in words."""

    port: str
    words: str
    answered: bool = True
    faults: tuple[str, ...] = ()
    """What keeps the device from use, with the next step."""
    advice: str | None = None
    scan: LaserScan | None = None
    """One scan, where it is a lidar that measures."""

    @property
    def fine(self) -> bool:
        """True where a device answers and nothing is wrong with it."""
        return self.answered and not self.faults


def examine(port: str, lidar_baud: int, wire: WireSession | None = None) -> Finding:
    """Find out which device answers at this port, and what it says.

    Nothing moves: the robot is opened, read and closed, its motors without power. A lidar's laser is off afterwards.
    """
    tried = []
    for look in (_examine_lidar, _examine_robot):
        try:
            return look(port, lidar_baud, wire)
        except NoDevice as silence:
            tried.append(str(silence).removeprefix(f"{port}: ").partition(";")[0])
        except PortLost as lost:
            return Finding(port, str(lost).removeprefix(f"{port}: "), answered=False)
        except RobotError as refusal:
            return Finding(port, "a device answers", faults=(str(refusal).removeprefix(f"{port}: "),))
    return Finding(port, f"{', and '.join(tried)}; is the device switched on, and its cable right?", answered=False)


def _examine_lidar(port: str, baud: int, wire: WireSession | None) -> Finding:
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
    return Finding(port, words, faults=tuple(faults), advice=_latency_advice(port), scan=scan)


def _try_laser(line: ScipLine, parameters: SensorParameters) -> tuple[list[str], LaserScan | None]:
    """Ask for the state, switch the laser on and take a scan; what the lidar said where it refused, and the scan."""
    faults: list[str] = []
    with suppress(RobotError, DecodeError):  # not every sensor knows II
        condition = SensorState.decode(line.ask_until_answered("II")).condition
        if not condition.startswith(_WORKS):
            faults.append(f'the lidar says of itself: "{condition}"; switch it off and on, and see its manual')
    try:
        switch_laser_on(line)
        data = _latest(line, parameters)
    except RobotError as refusal:
        said = str(refusal).removeprefix(f"{line.port.url}: ")
        return [*faults, f"{said}; switch it off and on; if it says that again, it needs repair"], None
    lidar = parameters.lidar
    fan = (lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max)
    return faults, LaserScan(0.0, *fan, data.ranges)


def _latest(line: ScipLine, parameters: SensorParameters) -> ScanData:
    """Ask for one scan, by MD where the sensor does not know GD."""
    single = ScanRequest("GD", parameters.first, parameters.last)
    for _ in range(3):
        with suppress(DecodeError):
            reply = line.ask(single.encode())
            if reply is not None and is_ok(reply.status):
                return decode_scan(reply)
            if reply is not None and reply.status.isdigit():
                line.ask_until_answered(single.encode())  # raises what the sensor said
            return decode_scan(_streamed(line, parameters))
    raise RobotError(f"{line.port.url}: the lidar's scans come damaged; look at its cable")


def _streamed(line: ScipLine, parameters: SensorParameters) -> Reply:
    request = ScanRequest("MD", parameters.first, parameters.last, scans=1)
    line.ask_until_answered(request.encode())
    reply = line.wait_for(replace(request, scans=0).encode(), 10.0 * parameters.scan_time)
    if reply is None:
        raise RobotError(f"{line.port.url}: the lidar obeys {request.encode()}, but sends no scan")
    return reply


def _examine_robot(port: str, _: int, wire: WireSession | None) -> Finding:
    line = ArcosLine(SerialPort(port, _FIRST_ROBOT_BAUD, wire), threading.Event())
    with closing(line.port):
        try:
            identity = connect_robot(line)
            config = _config_of(line)
            report = _report_of(line, identity)
        finally:
            with suppress(PortLost):
                disconnect_robot(line)
    words = f"robot {identity.name}, class {identity.robot_class}, subclass {identity.subclass}"
    if config is not None:
        words += f", firmware {config.firmware or 'unknown'}, watchdog {config.watchdog:g} s"
    if report is not None:
        words += f", battery {report.volts:.1f} V"
    return Finding(port, words, faults=tuple(_robot_faults(identity, config, report)), advice=_latency_advice(port))


def _config_of(line: ArcosLine) -> ArcosConfig | None:
    with suppress(RobotError):
        return read_config(line)
    return None


def _report_of(line: ArcosLine, identity: Identity) -> Sip | None:
    data, units = line.wait_for(is_sip), units_of(identity.subclass)
    if data is not None and units is not None:
        with suppress(DecodeError):
            return Sip.decode(data, units)
    return None


def _robot_faults(identity: Identity, config: ArcosConfig | None, report: Sip | None) -> Iterator[str]:
    if units_of(identity.subclass) is None:
        yield f"the units of a robot of subclass {identity.subclass!r} are not known here, but {', '.join(UNITS)}"
    elif report is None:
        yield "the robot reports nothing that makes sense; look at its cable, and switch it off and on"
    if config is None:
        yield "the robot does not say its settings (no CONFIG), so its watchdog is unknown; switch it off and on"
    elif not 0.0 < config.watchdog <= _LONGEST_WATCHDOG:
        watchdog = f"{config.watchdog:g} s" if config.watchdog else "off"
        yield f"its watchdog is {watchdog}; set it to at most {_LONGEST_WATCHDOG:g} s in its FLASH (ARCOScf: watchdog)"
    if report is not None:
        yield from _report_faults(report, config.low_battery if config else 0.0)


def _report_faults(report: Sip, low_battery: float) -> Iterator[str]:
    if report.e_stop:
        yield "its emergency stop is pressed; release it"
    if report.stalled:
        sides = [
            name
            for name, contacts in (("left", report.left_contacts), ("right", report.right_contacts))
            if contacts & 1
        ]
        yield f"it says that its {' and '.join(sides)} wheel cannot turn; free it"
    if report.front_bumpers or report.rear_bumpers:
        yield "one of its bumpers is pressed; push the robot free"
    if report.volts < low_battery:
        yield f"its battery has {report.volts:.1f} V, and is low below {low_battery:.1f} V; charge it"
    if report.faults:
        yield f"it reports faults, flags {report.faults:#06x}; see its manual"


def _latency_advice(port: str) -> str | None:
    timer = latency_timer(port)
    return timer.advice if timer else None
