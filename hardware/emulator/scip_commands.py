"""The commands of an emulated URG-04LX in SCIP 2.0 that do not measure: the action of each, and its source."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from hardware.emulator.sensor_settings import DEFAULT_BAUD, SensorSettings
from hardware.scip.commands import BAUDS
from hardware.scip.information import SensorState, VersionInfo
from hardware.scip.reply import Reply
from hardware.scip.time_stamp import encode_time

VERSION: Final = VersionInfo(
    "Hokuyo Automatic Co.,Ltd.", "SOKUIKI Sensor URG-04LX", "3.1.04(02/Aug./2007)", "SCIP 2.0", "H0000000"
)
_IMPOSSIBLE_BAUD: Final = 38400
_SLOWEST: Final = 10
_INITIAL_SPEED: Final = 99

Action = Callable[[SensorSettings, str], Reply]


@dataclass(frozen=True, slots=True)
class CommandRow:
    """A command by its first two letters: the characters of its parameter, its action, and the source for it.

    A page number refers to the specification C-42-03320B; ``real`` is the log of a URG-04LX, firmware 3.1.04.
    """

    width: int
    action: Action
    evidence: str


def answer(settings: SensorSettings, command: str) -> Reply:
    """Return the reply to a command, without the client's note; 0E for an unknown command."""
    row = COMMANDS.get(command[:2])
    if row is None:
        return Reply(command, "0E")
    if len(command) != 2 + row.width:
        return Reply(command, "0C" if len(command) < 2 + row.width else "0E")
    return row.action(settings, command)


def _switch_on(settings: SensorSettings, _: str) -> Reply:
    was_on, settings.laser = settings.laser, True
    return Reply("BM", "02" if was_on else "00")


def _quit(settings: SensorSettings, command: str) -> Reply:
    settings.stop()
    return Reply(command, "00")


def _reset(settings: SensorSettings, command: str) -> Reply:
    settings.time = 0.0
    if command == "RS":
        settings.baud = DEFAULT_BAUD
    return _quit(settings, command)


def _adjust(settings: SensorSettings, command: str) -> Reply:
    if command[2] not in "012":
        return Reply(command, "01")
    if command == "TM1":
        lines = (encode_time(settings.time),) if settings.adjusting else ()
        return Reply(command, "00" if lines else "04", lines)
    on = command == "TM0"
    if settings.adjusting == on:
        return Reply(command, "02" if on else "03")
    settings.adjusting = on
    return _quit(settings, command)


def _set_baud(settings: SensorSettings, command: str) -> Reply:
    if not command[2:].isdecimal():
        return Reply(command, "01")
    baud = int(command[2:])
    if baud not in BAUDS:
        return Reply(command, "02")
    if baud == _IMPOSSIBLE_BAUD:
        return Reply(command, "04")
    was, settings.baud = settings.baud, baud
    return Reply(command, "03" if was == baud else "00")


def _set_motor(_: SensorSettings, command: str) -> Reply:
    if not command[2:].isdecimal():
        return Reply(command, "01")
    ratio = int(command[2:])
    if ratio == _INITIAL_SPEED:
        return Reply(command, "00")
    return Reply(command, "03" if ratio == 0 else "04" if ratio <= _SLOWEST else "02")


def _state(settings: SensorSettings, _: str) -> Reply:
    origin = "Default setting by user" if settings.baud == DEFAULT_BAUD else "Setting by command"
    return SensorState(
        settings.parameters.model,
        settings.laser,
        "Initial(600[rpm])<-Default setting by user",
        "CLASSIC",
        f"{settings.baud}[bps]<-{origin}",
        settings.time,
        "Sensor works well.",
    ).encode()


COMMANDS: Final[dict[str, CommandRow]] = {
    "VV": CommandRow(0, lambda *_: VERSION.encode(), "p. 20; real"),
    "PP": CommandRow(0, lambda settings, _: settings.parameters.encode(), "p. 21; real"),
    "II": CommandRow(0, _state, "p. 22; real"),
    "BM": CommandRow(0, _switch_on, "p. 14; real: 02 where it is on"),
    "QT": CommandRow(0, _quit, "p. 15: always 00"),
    "RS": CommandRow(0, _reset, "p. 15: bit rate, motor and clock too"),
    "RT": CommandRow(0, _reset, "hokuyoaist: as RS, but for bit rate and motor"),
    "TM": CommandRow(1, _adjust, "p. 16: 01 unknown code, 02 already on, 03 already off, 04 TM1 while off"),
    "SS": CommandRow(6, _set_baud, "p. 17: 01 not a number, 02 unknown rate, 03 no change, 04 not 38400 (p. 4)"),
    "CR": CommandRow(2, _set_motor, "p. 17: 01 not a number, 02 out of range, 03 no change (real), 04 not possible"),
    "HS": CommandRow(
        1, lambda _, c: Reply(c, "03" if c[2] in "01" else "01"), "p. 18: 01 parameter, 03 firmware before 3.2.00"
    ),
}
"""Commands by their letters. DB (from firmware 3.3), RB, GE and ME (of later models) are undefined: 0E, p. 23."""
