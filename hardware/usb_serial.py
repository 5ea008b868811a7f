"""The serial ports of this machine: those that may belong to a robot or a lidar, and their latency."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from serial.tools.list_ports import comports

_HOKUYO: Final = 0x15D1
_ADAPTERS: Final = {
    _HOKUYO: "Hokuyo",
    0x0403: "FTDI",
    0x067B: "Prolific",
    0x0557: "ATEN",
    0x10C4: "Silicon Labs",
    0x1A86: "WCH",
    0x9710: "MosChip",
}
"""Makers, by USB vendor number, of lidars and of the adapters of robots and lidars."""
_USB_SERIAL: Final = Path("/sys/bus/usb-serial/devices")
_SHORTEST: Final = 1
"""Milliseconds: the least that FTDI's driver accepts."""


@dataclass(frozen=True, slots=True)
class ListedPort:
    """A serial port of this machine, as the system lists it."""

    device: str
    description: str
    likely: bool
    """True if a robot or a lidar may be connected; False for modems, boards and receivers of other makers."""


@dataclass(frozen=True, slots=True)
class LatencyTimer:
    """Time for which an FTDI adapter holds bytes back to send more of them together."""

    file: Path
    milliseconds: int

    @property
    def advice(self) -> str | None:
        """Advice against a long latency; None if it is as short as it can be."""
        if self.milliseconds <= _SHORTEST:
            return None
        return (
            f"its FTDI adapter holds bytes back for up to {self.milliseconds} ms, so stamps come late; "
            f"run: echo {_SHORTEST} | sudo tee {self.file} (docs/hardware.md makes that last)"
        )


def listed_ports() -> list[ListedPort]:
    """List the serial ports of this machine, by name: COM3 before COM12."""
    ports = sorted(comports(), key=lambda port: _with_numbers(port.device))
    return [
        ListedPort(port.device, "no USB port" if port.vid is None else port.description, port.vid in _ADAPTERS)
        for port in ports
    ]


def _with_numbers(name: str) -> list[str | int]:
    """Split a name into text and numbers, so that COM3 comes before COM12."""
    return [int(part) if part.isdecimal() else part for part in re.split(r"([0-9]+)", name)]


def latency_timer(port: str, devices: Path = _USB_SERIAL) -> LatencyTimer | None:
    """Return the latency timer of the adapter behind a port, which may be a link; None if it has none."""
    try:
        file = devices / Path(port).resolve().name / "latency_timer"
        return LatencyTimer(file, int(file.read_text(encoding="ascii")))
    except (OSError, ValueError):
        return None
