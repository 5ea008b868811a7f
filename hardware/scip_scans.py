"""The scans that a SCIP sensor can send: the largest request for its line, and the reason if none come."""

from math import ceil
from typing import Final

from hardware.scip.commands import ScanRequest
from hardware.scip.information import SensorParameters
from hardware.scip.reply import DATA_LINE
from hardware.scip.status import is_ok, status_meaning
from hardware.scip_line import ScipLine
from hardware.serial_port import BITS_PER_BYTE
from slam.errors import RobotError

_FAULTY: Final = "01"
_HEAD: Final = 30
"""Characters of an answer before its data, at most."""
_FILL: Final = 0.9
"""Share of the line's bit rate that scans may take."""


def choose_request(parameters: SensorParameters, baud: int | None) -> ScanRequest:
    """Choose the largest scans that the bit rate of this line allows; None is a line without a bit rate."""
    full = ScanRequest("MD", parameters.first, parameters.last)
    if baud is None or _turns_per_scan(full, parameters, baud) <= 1:
        return full
    short = ScanRequest("MS", parameters.first, parameters.last)
    return ScanRequest("MS", short.first, short.last, interval=min(9, _turns_per_scan(short, parameters, baud) - 1))


def _turns_per_scan(request: ScanRequest, parameters: SensorParameters, baud: int) -> int:
    """Return the number of turns for which the answer of one scan occupies the line."""
    size = request.values * request.width
    length = size + 2 * ceil(size / DATA_LINE) + _HEAD
    return ceil(length * BITS_PER_BYTE / baud / (parameters.scan_time * _FILL))


def switch_laser_on(line: ScipLine) -> None:
    """Switch the laser on; RobotError if it is faulty. Other answers to BM do not matter."""
    reply = line.ask("BM")
    if reply is not None and reply.status == _FAULTY:
        raise RobotError(f"{line.port.url}: the lidar says: {status_meaning('BM', reply.status)} (BM, status 01)")


def reason_for_silence(line: ScipLine, parameters: SensorParameters) -> str | None:
    """Ask a sensor that sends no continuous scans for a single one; return the reason if it refuses that too."""
    command = ScanRequest("GD", parameters.first, parameters.last).encode()
    reply = line.ask(command)
    if reply is None or is_ok(reply.status) or not reply.status.isdigit():
        return None
    return f"status {reply.status} to {command}, {status_meaning(command, reply.status)}"
