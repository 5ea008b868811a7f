"""The replies of an emulated sensor to each command, in both versions of SCIP."""

import re
from dataclasses import replace
from typing import Final

from hardware import DecodeError
from hardware.emulator.scip_commands import VERSION, answer
from hardware.emulator.sensor_settings import SensorSettings
from hardware.scip.commands import BAUDS, TO_SCIP2, ScanRequest
from hardware.scip.reply import Reply

_OLD_FIRMWARE: Final = "3.1.04,08/02/07(20-4095[mm],240[deg],44-725[step],600[rpm])"
_OLD_VERSION: Final = replace(VERSION, firmware=_OLD_FIRMWARE, protocol="SCIP 1.1")
_LONGEST_NOTE: Final = 16
_LETTERS_OF_NOTE: Final = re.compile(r"[A-Za-z0-9 ._+@]*")
_FIELDS: Final = (
    ("01", slice(2, 6)),
    ("02", slice(6, 10)),
    ("03", slice(10, 12)),
    ("06", slice(12, 13)),
    ("07", slice(13, 15)),
)
"""Parameters of MD and MS: the status of the reply to one that is not a number, and its position in the command. GD and
GS have the first three."""


def reply_to(settings: SensorSettings, text: str) -> Reply:
    """Return the reply in SCIP 2.0; replies to GD and GS still lack the scan."""
    command, _, note = text.partition(";")
    if len(note) > _LONGEST_NOTE:
        return Reply(text, "0G")
    if not _LETTERS_OF_NOTE.fullmatch(note):
        return Reply(text, "0H")
    if settings.adjusting and not command.startswith("TM"):
        return Reply(text, "0E")
    if command[:2] in ("MD", "MS", "GD", "GS"):
        return _measure(settings, command, text)
    return replace(answer(settings, command), echo=text)


def reply_to_scip1(settings: SensorSettings, text: str) -> Reply:
    """Return the reply in SCIP 1.1; a reply to G still lacks the scan."""
    if text == TO_SCIP2:
        settings.scip2 = True
        return Reply(text, "0")
    if text == "V":
        return _OLD_VERSION.encode("V")
    if text in ("L0", "L1"):
        settings.laser = text == "L1"
        return Reply(text, "0")
    if text[:1] == "S" and len(text) == 14 and text[1:].isdigit() and int(text[1:7]) in BAUDS:
        settings.baud = int(text[1:7])
        return Reply(text, "0")
    try:
        request = ScanRequest.decode(text)
    except DecodeError:
        return Reply(text, "E")
    if request.letters != "G" or not request.first <= request.last <= settings.last_step:
        return Reply(text, "E")
    settings.laser = True  # a sensor in SCIP 1.1 measures without a command
    return Reply(text, "0")


def _measure(settings: SensorSettings, command: str, text: str) -> Reply:
    try:
        request = ScanRequest.decode(command)
    except DecodeError:
        return Reply(text, _wrong_number(command))
    if request.last > settings.last_step:
        return Reply(text, "04")
    if request.last < request.first:
        return Reply(text, "05")
    if request.continuous:
        settings.laser, settings.streaming, settings.note = True, request, text[len(command) :]
    elif not settings.laser:
        return Reply(text, "10")
    return Reply(text, "00")


def _wrong_number(command: str) -> str:
    """Return the status for a wrong parameter of a measuring command; 0C for too many or too few."""
    fields = _FIELDS if command[0] == "M" else _FIELDS[:3]
    if len(command) != fields[-1][1].stop:
        return "0C"
    return next(status for status, field in fields if not command[field].isdecimal())
