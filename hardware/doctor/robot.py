"""Examines a robot that speaks ARCOS: its model, its settings, and one report."""

import threading
from collections.abc import Iterator
from contextlib import closing, suppress
from typing import Final

from hardware import DecodeError
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import UNITS, Identity, units_of
from hardware.arcos.sip import Sip, is_sip
from hardware.arcos_line import ArcosLine
from hardware.arcos_session import connect_robot, disconnect_robot, read_config
from hardware.doctor.finding import Finding
from hardware.serial_port import PortLost, SerialPort
from hardware.wire.session import WireSession
from slam.errors import RobotError

_FIRST_ROBOT_BAUD: Final = 9600
_LONGEST_WATCHDOG: Final = 2.0
"""Seconds, the default of ``hardware.max_watchdog``."""


def examine_robot(port: str, _: int, wire: WireSession | None) -> Finding:
    """Open the robot, read its settings and a report, and close it; NoDevice if none answers."""
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
    return Finding(port, words, faults=tuple(_robot_faults(identity, config, report)))


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
        yield f"the units of a robot of subclass {identity.subclass!r} are unknown; known are {', '.join(UNITS)}"
    elif report is None:
        yield "the robot sends nothing that can be decoded; check its cable, and switch it off and on"
    if config is None:
        yield "the robot does not report its settings (no CONFIG), so its watchdog is unknown; switch it off and on"
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
        yield f"it reports that its {' and '.join(sides)} wheel cannot turn; free it"
    if report.front_bumpers or report.rear_bumpers:
        yield "one of its bumpers is pressed; push the robot free"
    if report.volts < low_battery:
        yield f"its battery has {report.volts:.1f} V, and is low below {low_battery:.1f} V; charge it"
    if report.faults:
        yield f"it reports faults, flags {report.faults:#06x}; see its manual"
