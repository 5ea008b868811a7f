"""Opens a P3-DX: finds it on a line, checks its settings, and sends it the scenario's limits."""

import logging
import threading
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Final

from hardware.arcos.commands import Command, CommandId
from hardware.arcos.config_packet import ArcosConfig
from hardware.arcos.model import UNITS, ArcosUnits, units_of
from hardware.arcos_line import ArcosLine
from hardware.arcos_session import connect_robot, disconnect_robot, read_config, speed_up
from hardware.serial_port import PortLost, SerialPort
from hardware.wire.session import WireSession
from slam.errors import RobotError
from slam.scenario.hardware_config import FlashSettings, HardwareConfig
from slam.scenario.robot_config import Limits

_LOG: Final = logging.getLogger("hopslam.p3dx")
_FIRST_BAUD: Final = 9600
_BLIND_SPOT: Final = 0.5
"""Longest watchdog, seconds, without a warning: a robot drives on for this time after its link is lost."""


@dataclass(frozen=True, slots=True)
class OpenedP3dx:
    """An open robot, its motors without power: its line, the units of its reports, and its FLASH settings."""

    line: ArcosLine
    units: ArcosUnits
    settings: ArcosConfig


def open_p3dx(config: HardwareConfig, limits: Limits, closing: threading.Event, wire: WireSession) -> OpenedP3dx:
    """Open the robot.

    RobotError if no P3-DX answers, its watchdog is off or too slow, or it does not report its ticks.
    """
    line = ArcosLine(SerialPort(config.robot_port, _FIRST_BAUD, wire), closing)
    try:
        subclass = connect_robot(line).subclass
        try:
            return _set_up(line, subclass, config, limits)
        except RobotError:
            with suppress(PortLost):
                disconnect_robot(line)
            raise
    except BaseException:
        line.port.close()
        raise


def _set_up(line: ArcosLine, subclass: str, config: HardwareConfig, limits: Limits) -> OpenedP3dx:
    units = units_of(subclass)
    if units is None:
        known = ", ".join(UNITS)
        raise RobotError(
            f"{line.port.url}: the units of a robot of subclass {subclass!r} are unknown; known are {known}"
        )
    settings = read_config(line, _stated_settings(config.settings))
    _check_watchdog(line, settings.watchdog, config.max_watchdog)
    by_encoders = config.odometry == "encoders"
    if by_encoders and not settings.ticks_per_metre:
        cure = "set hardware.odometry=position, or hardware.settings.ticks_per_metre"
        raise RobotError(f"{line.port.url}: the robot does not report the ticks of its wheels; {cure}")
    speed_up(line, settings)
    for command, quantity in (
        (CommandId.SETV, limits.linear),
        (CommandId.SETA, limits.acceleration),
        (CommandId.SETA, -limits.deceleration),
        (CommandId.SETRV, limits.angular),
        (CommandId.SETRA, limits.angular_acceleration),
        (CommandId.SETRA, -limits.angular_acceleration),
    ):
        line.send(Command.of(command, quantity))
    line.send(Command(CommandId.ENABLE, 0))
    line.send(Command(CommandId.ENCODER, 2 * by_encoders))
    return OpenedP3dx(line, units, settings)


def _stated_settings(settings: FlashSettings) -> ArcosConfig:
    """Return the settings that the scenario states, for a robot that does not report its own."""
    return ArcosConfig(
        watchdog=settings.watchdog,
        ticks_per_metre=settings.ticks_per_metre or 0.0,
        front_bumpers=settings.front_bumpers,
        rear_bumpers=settings.rear_bumpers,
    )


def _check_watchdog(line: ArcosLine, watchdog: float, longest: float) -> None:
    if not 0.0 < watchdog <= longest:
        raise RobotError(
            f"{line.port.url}: the robot's watchdog is {f'{watchdog:g} s' if watchdog else 'off'}; "
            f"set it to at most {longest:g} s in its FLASH (ARCOScf: watchdog), or raise hardware.max_watchdog"
        )
    if watchdog > _BLIND_SPOT:
        _warn_of_blind_spot(line.port.url, watchdog)


@cache
def _warn_of_blind_spot(url: str, watchdog: float) -> None:
    """Log a warning once for each robot, however often it is opened."""
    _LOG.warning(
        "%s: if unplugged, the robot drives on until its watchdog stops it after %g s; ARCOScf shortens it",
        url,
        watchdog,
    )
