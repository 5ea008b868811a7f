"""The replies of an emulated sensor to each command, and the changes that the command makes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from hardware import DecodeError
from hardware.scip.commands import BAUDS, TO_SCIP2, ScanRequest, note_of, without_note
from hardware.scip.information import SensorParameters, SensorState, VersionInfo
from hardware.scip.reply import Reply
from hardware.scip.time_stamp import encode_time

_VERSION: Final = VersionInfo(
    "Hokuyo Automatic Co.,Ltd.", "SOKUIKI Sensor URG-04LX", "3.1.04(02/Aug./2007)", "SCIP 2.0", "H0000000"
)
_OLD_FIRMWARE: Final = "3.1.04,08/02/07(20-4095[mm],240[deg],44-725[step],600[rpm])"
_OLD_VERSION: Final = replace(_VERSION, firmware=_OLD_FIRMWARE, protocol="SCIP 1.1")
_DEFAULT_BAUD: Final = 19200
_LAST_STEP: Final = 768
_FIELDS: Final = (
    ("01", slice(2, 6)),
    ("02", slice(6, 10)),
    ("03", slice(10, 12)),
    ("06", slice(12, 13)),
    ("07", slice(13, 15)),
)
"""Status for each number of MD and MS that is no number, and its place; GD and GS have the first three."""


@dataclass(slots=True)
class SensorSettings:
    """The settings that commands change."""

    parameters: SensorParameters
    time: float = 0.0
    """Seconds of the sensor's clock."""
    scip2: bool = False
    laser: bool = False
    baud: int = _DEFAULT_BAUD
    streaming: ScanRequest | None = None
    """Request for the scans that come by themselves; its ``scans`` are left, 0 for no end."""
    note: str = ""
    """Note that the client appended to the command that began them."""
    adjusting: bool = False
    """True between TM0 and TM2."""


def reply_to(settings: SensorSettings, text: str) -> Reply:
    """Return the reply in SCIP 2.0; that to GD and GS still lacks the scan."""
    command = without_note(text)
    if settings.adjusting and not command.startswith("TM"):
        return Reply(text, "0E")
    if command[:2] in ("MD", "MS", "GD", "GS"):
        return _measure(settings, command, text)
    action = _ACTIONS.get(command) or _ACTIONS.get(command[:2])
    if action is None:
        return Reply(text, "0E")
    reply = action(settings, command)
    return Reply(text, reply.status, reply.lines)


def reply_to_scip1(settings: SensorSettings, text: str) -> Reply:
    """Return the reply in SCIP 1.1; that to G still lacks the scan."""
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
    if request.letters != "G" or not request.first <= request.last <= _LAST_STEP:
        return Reply(text, "E")
    settings.laser = True  # a sensor in SCIP 1.1 measures without being told to
    return Reply(text, "0")


def _measure(settings: SensorSettings, command: str, text: str) -> Reply:
    try:
        request = ScanRequest.decode(command)
    except DecodeError:
        return Reply(text, _wrong_number(command))
    if request.last > _LAST_STEP:
        return Reply(text, "04")
    if request.last < request.first:
        return Reply(text, "05")
    if request.continuous:
        settings.laser, settings.streaming, settings.note = True, request, note_of(text)
    elif not settings.laser:
        return Reply(text, "10")
    return Reply(text, "00")


def _wrong_number(command: str) -> str:
    """Return the status for the wrong number of a measuring command; 0C where there are too many or too few."""
    fields = _FIELDS if command[0] == "M" else _FIELDS[:3]
    if len(command) != fields[-1][1].stop:
        return "0C"
    return next(status for status, field in fields if not command[field].isdecimal())


def _switch_on(settings: SensorSettings, _: str) -> Reply:
    was_on, settings.laser = settings.laser, True
    return Reply("BM", "02" if was_on else "00")


def _quit(settings: SensorSettings, _: str) -> Reply:
    settings.laser, settings.streaming = False, None
    return Reply("QT", "00")


def _reset(settings: SensorSettings, command: str) -> Reply:
    settings.time = 0.0
    if command == "RS":
        settings.baud = _DEFAULT_BAUD
    return _quit(settings, command)


def _set_baud(settings: SensorSettings, command: str) -> Reply:
    if len(command) != 8 or not command[2:].isdecimal():
        return Reply(command, "01")
    if int(command[2:]) not in BAUDS:
        return Reply(command, "02")
    was, settings.baud = settings.baud, int(command[2:])
    return Reply(command, "03" if was == settings.baud else "00")


def _state(settings: SensorSettings, _: str) -> Reply:
    origin = "Default setting by user" if settings.baud == _DEFAULT_BAUD else "Setting by command"
    return SensorState(
        settings.parameters.model,
        settings.laser,
        "Initial(600[rpm])<-Default setting by user",
        "CLASSIC",
        f"{settings.baud}[bps]<-{origin}",
        settings.time,
        "Sensor works well.",
    ).encode()


def _adjust(settings: SensorSettings, command: str) -> Reply:
    if command == "TM1":
        lines = (encode_time(settings.time),) if settings.adjusting else ()
        return Reply(command, "00" if lines else "04", lines)
    on = command == "TM0"
    if settings.adjusting == on:
        return Reply(command, "02" if on else "03")
    settings.adjusting, settings.laser, settings.streaming = on, False, None
    return Reply(command, "00")


_ACTIONS: Final[dict[str, Callable[[SensorSettings, str], Reply]]] = {
    "VV": lambda *_: _VERSION.encode(),
    "PP": lambda settings, _: settings.parameters.encode(),
    "II": _state,
    "BM": _switch_on,
    "QT": _quit,
    "RS": _reset,
    "RT": _reset,
    "TM0": _adjust,
    "TM1": _adjust,
    "TM2": _adjust,
    "SS": _set_baud,
    "CR00": lambda _, command: Reply(command, "03"),
    "CR99": lambda _, command: Reply(command, "00"),
    "CR": lambda _, command: Reply(command, "04"),
    "HS0": lambda _, command: Reply(command, "00"),
    "HS1": lambda _, command: Reply(command, "00"),
}
