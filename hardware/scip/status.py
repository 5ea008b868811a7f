"""The meaning of a status, the two characters behind an echo (C-42-03320B)."""

from typing import Final

_GENERAL: Final = {
    "0A": "it could not make an answer",
    "0B": "the same command twice, or its buffer is full",
    **dict.fromkeys(("0C", "0F"), "parameters are missing"),
    **dict.fromkeys(("0D", "0E"), "not a command, or not allowed now"),
    "0G": "the note is longer than 16 characters",
    "0H": "the note has characters that it may not have",
    "0I": "the sensor is in firmware update mode",
    "0L": "the sensor is in an abnormal state",
}
_SPECIAL: Final = {
    ("BM", "01"): "the laser is faulty",
    ("BM", "02"): "the laser was on already",
    ("GD", "10"): "the laser is off",
    ("GS", "10"): "the laser is off",
    ("SS", "01"): "the bit rate is not a number",
    ("SS", "02"): "no such bit rate",
    ("SS", "03"): "the bit rate was that already",
    ("SS", "04"): "the bit rate is not supported",
    ("CR", "01"): "the speed is not a number",
    ("CR", "02"): "the speed is out of range",
    ("CR", "03"): "the motor turned at that speed already",
    ("CR", "04"): "the speed is not supported",
    ("HS", "01"): "unknown sensitivity",
    ("HS", "02"): "the sensitivity was that already",
    ("HS", "03"): "this firmware has one sensitivity",
    ("TM", "01"): "no such control code",
    ("TM", "02"): "clock mode is on already",
    ("TM", "03"): "clock mode is off already",
    ("TM", "04"): "clock mode is off: send TM0 first",
}
_PARAMETERS: Final = {
    "01": "the first step is not a number",
    "02": "the last step is not a number",
    "03": "the cluster is not a number",
    "04": "the last step is beyond the sensor's",
    "05": "the last step comes before the first",
    "06": "the interval is not a number",
    "07": "the number of scans is not a number",
}


def is_ok(status: str) -> bool:
    """Return True if the command was obeyed: 00 or 99 (a continuous scan), 0 in SCIP 1.1."""
    return status in ("00", "99", "0")


def status_meaning(command: str, status: str) -> str:
    """Describe a status in words."""
    if is_ok(status):
        return "done"
    words = _SPECIAL.get((command[:2], status)) or _GENERAL.get(status)
    if words is None and command[:2] in ("MD", "MS", "GD", "GS"):
        words = _PARAMETERS.get(status) or ("the sensor has a hardware fault" if status.isdigit() else None)
    return words or "no known meaning"
