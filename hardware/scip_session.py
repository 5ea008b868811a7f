"""The dialogue with a SCIP sensor: find it on the line in any state, ask for its parameters, stop its scans."""

import logging
import time
from contextlib import suppress
from typing import Final

from hardware import DecodeError
from hardware.scip.commands import TO_SCIP2, set_baud
from hardware.scip.frames import Lines
from hardware.scip.information import SensorParameters, VersionInfo
from hardware.scip.reply import Reply, decode_reply, find_reply
from hardware.scip.status import status_meaning
from hardware.scip_line import ANSWER, ScipLine
from hardware.serial_port import NoDevice, PortLost
from slam.errors import RobotError

_LOG: Final = logging.getLogger("hopslam.urg04lx")
_OLD_BAUDS: Final = (19200, 115200)
_BAUD_SEARCH: Final = (19200, 115200, 57600, 38400, 500000, 750000, 250000)
_LAST_ANSWER: Final = 0.3
"""Seconds to wait for the answer to the last QT."""
_TRIES: Final = 3
_ROUNDS: Final = 5
"""Total number of commands sent to switch a sensor to SCIP 2.0."""
_IN_TIME_MODE: Final = ("0E", "10")
"""Status of a command that is refused between TM0 and TM2: of a URG-04LX, and of later sensors."""
_UPDATE: Final = (
    "speaks SCIP 1 only: update the firmware to 3.0 or later with the tool of Hokuyo's download page (Windows, over "
    "USB), or have the dealer do it"
)
_MAX_UNANSWERED: Final = 2
"""Unanswered commands after which a bit rate is given up."""


def connect_lidar(line: ScipLine, baud: int) -> None:
    """Find the sensor's bit rate, stop its scans, bring it to SCIP 2.0, and to ``baud`` if that is faster.

    RobotError if no sensor answers.
    """
    others = [rate for rate in _BAUD_SEARCH if rate != baud]
    bauds = [baud, *others] if line.port.has_baud else [line.port.baud]
    for rate in bauds:
        line.port.baud = rate
        if _stop_and_switch_to_scip2(line):
            _change_baud(line, baud)
            return
    for rate in _OLD_BAUDS if line.port.has_baud else bauds:
        line.port.baud = rate
        if (old := line.ask("V")) is not None:
            raise RobotError(f"{line.port.url}: {_too_old(old)}")
    tried = f" at {', '.join(map(str, bauds))} baud" if line.port.has_baud else ""
    raise NoDevice(f"{line.port.url}: no SCIP sensor answers{tried}; is it powered, and this the right port?")


def identify(line: ScipLine) -> tuple[VersionInfo, SensorParameters]:
    """Ask the sensor for its identity, for display only, and for its parameters, which the driver needs."""
    version = _version(line)
    try:
        return version, SensorParameters.decode(line.ask_until_answered("PP"))
    except DecodeError as error:
        raise RobotError(f"{line.port.url}: the lidar's description makes no sense: {error}") from error


def stop_scans(line: ScipLine) -> None:
    """Switch the laser off, which ends the scans."""
    until = time.monotonic() + _LAST_ANSWER
    with suppress(PortLost):
        line.send("QT")
        while (left := until - time.monotonic()) > 0.0:
            if any(_is_answer(frame.lines, "QT") for frame in line.receive(left)):
                return


def _stop_and_switch_to_scip2(line: ScipLine) -> bool:
    """Stop the scans of a sensor and switch it to SCIP 2.0; False if none answers at this bit rate.

    RobotError for a sensor that answers, but does not have SCIP 2.0.
    """
    line.send("")  # ends what an earlier client may have left unfinished
    reply, unanswered = None, 0
    for _ in range(_ROUNDS):
        answer = line.ask("QT")
        if answer is None:
            unanswered += 1
            if unanswered == _MAX_UNANSWERED:
                break
            continue
        reply = answer
        if reply.status == "00":
            return True
        line.ask("TM2" if reply.status in _IN_TIME_MODE else TO_SCIP2)
    if reply is None:
        return False
    if len(reply.status) == 1:
        raise RobotError(f"{line.port.url}: {_too_old(line.ask('V'))}")
    why = status_meaning("QT", reply.status)
    raise RobotError(f"{line.port.url}: the lidar does not stop: status {reply.status} to QT, {why}")


def _too_old(reply: Reply | None) -> str:
    """Advise what to do with a sensor that has SCIP 1 only, with its version if it gave one."""
    with suppress(DecodeError):
        if reply is not None:
            firmware = VersionInfo.decode(reply).firmware
            return f"the lidar's firmware, {firmware}, {_UPDATE}"
    return f"the lidar's firmware {_UPDATE}"


def _version(line: ScipLine) -> VersionInfo:
    """Ask for the sensor's identity; damaged or missing parts are unknown, with a warning."""
    lines: Lines = ()
    for _ in range(_TRIES):
        line.send("VV")
        until = time.monotonic() + ANSWER
        while not lines and (left := until - time.monotonic()) > 0.0:
            lines = next((frame.lines for frame in line.receive(left) if frame.lines[0].endswith(b"VV")), ())
        if lines:
            break
    with suppress(DecodeError):
        return VersionInfo.decode(decode_reply(lines))
    _LOG.warning(
        "%s: the lidar does not identify itself: its answer to VV is damaged, or a refusal",
        line.port.url,
    )
    return VersionInfo.decode_leniently(lines)


def _change_baud(line: ScipLine, baud: int) -> None:
    """Change the bit rate of sensor and port; a sensor on USB takes the command, and nothing changes."""
    if not line.port.has_baud or line.port.baud == baud:
        return
    before = line.port.baud
    reply = line.ask(set_baud(baud))
    if reply is None or reply.status not in ("00", "03"):
        return
    line.port.baud = baud
    if line.ask("QT") is None:
        line.port.baud = before


def _is_answer(lines: Lines, command: str) -> bool:
    reply = find_reply(lines)
    return reply is not None and reply.echo == command
