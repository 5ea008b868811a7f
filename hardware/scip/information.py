"""The sensor's description of itself: the answers to VV, PP and II, lines of ``KEY:value;``."""

from dataclasses import dataclass
from math import pi
from typing import Self

from hardware import DecodeError
from hardware.scip.frames import Lines
from hardware.scip.reply import Reply
from hardware.scip.time_stamp import decode_hex_time, encode_hex_time
from slam.lidars import Lidar


def entries(reply: Reply) -> dict[str, str]:
    """Return the values by their keys; DecodeError for a line of another form. SCIP 1.1 has no semicolons."""
    pairs = [line.decode("latin-1").removesuffix(";").partition(":") for line in reply.lines]
    if not all(colon for _, colon, _ in pairs):
        raise DecodeError("a line that is not KEY:value")
    return {key: value for key, _, value in pairs}


def _reply(command: str, **values: object) -> Reply:
    return Reply(command, "00", tuple(f"{key}:{value};".encode("latin-1") for key, value in values.items()))


def _whole(values: dict[str, str], key: str) -> int:
    try:
        return int(values[key])
    except (KeyError, ValueError):
        raise DecodeError(f"{key} is missing or not a number") from None


def _words(values: dict[str, str], *keys: str) -> list[str]:
    try:
        return [values[key] for key in keys]
    except KeyError as missing:
        raise DecodeError(f"{missing.args[0]} is missing") from None


@dataclass(frozen=True, slots=True)
class VersionInfo:
    """The sensor's identity: the answer to VV, or to V of SCIP 1.1."""

    vendor: str
    product: str
    firmware: str
    protocol: str
    serial_number: str

    @classmethod
    def decode(cls, reply: Reply) -> Self:
        """Read the answer; DecodeError if a value is missing."""
        return cls(*_words(entries(reply), "VEND", "PROD", "FIRM", "PROT", "SERI"))

    @classmethod
    def decode_leniently(cls, lines: Lines) -> Self:
        """Read what arrived between two empty lines, whatever the sums; for messages to people only."""
        pairs = [line.decode("latin-1").partition(":") for line in lines]
        values = {key: value.rpartition(";")[0] for key, colon, value in pairs if colon}
        return cls(*(values.get(key) or "unknown" for key in ("VEND", "PROD", "FIRM", "PROT", "SERI")))

    def encode(self, command: str = "VV") -> Reply:
        """Return the answer."""
        values = (self.vendor, self.product, self.firmware, self.protocol, self.serial_number)
        reply = _reply(command, **dict(zip(("VEND", "PROD", "FIRM", "PROT", "SERI"), values, strict=True)))
        old = command == "V"
        return Reply(command, "0", tuple(line.removesuffix(b";") for line in reply.lines)) if old else reply


@dataclass(frozen=True, slots=True)
class SensorParameters:
    """The sensor's parameters: the answer to PP."""

    model: str
    range_min: float
    """Metres."""
    range_max: float
    resolution: int
    """Steps per turn."""
    first: int
    """First step that is measured."""
    last: int
    """Last step that is measured."""
    front: int
    """The step that points forward."""
    scan_time: float
    """Seconds per turn."""

    @property
    def lidar(self) -> Lidar:
        """The sensor's fan from the first step to the last."""
        step = 2.0 * pi / self.resolution
        first = (self.first - self.front) * step
        return Lidar(first, step, self.last - self.first + 1, self.range_min, self.range_max, self.scan_time)

    @property
    def step_time(self) -> float:
        """Seconds from one step to the next."""
        return self.scan_time / self.resolution

    @classmethod
    def decode(cls, reply: Reply) -> Self:
        """Read the answer; DecodeError if a value is missing or impossible."""
        values = entries(reply)
        near, far, turn, first, last, front, rpm = (
            _whole(values, key) for key in ("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN")
        )
        if not (0 < turn and 0 < rpm and 0 <= first < last <= turn and 0 <= near < far):
            raise DecodeError("parameters that cannot be")
        return cls(_words(values, "MODL")[0], near / 1000.0, far / 1000.0, turn, first, last, front, 60.0 / rpm)

    def encode(self) -> Reply:
        """Return the answer."""
        return _reply(
            "PP",
            MODL=self.model,
            DMIN=round(self.range_min * 1000.0),
            DMAX=round(self.range_max * 1000.0),
            ARES=self.resolution,
            AMIN=self.first,
            AMAX=self.last,
            AFRT=self.front,
            SCAN=round(60.0 / self.scan_time),
        )


@dataclass(frozen=True, slots=True)
class SensorState:
    """The sensor's state: the answer to II."""

    model: str
    laser: bool
    motor: str
    mode: str
    bit_rate: str
    time: float
    """The sensor's clock, seconds."""
    condition: str

    @classmethod
    def decode(cls, reply: Reply) -> Self:
        """Read the answer; DecodeError if a value is missing."""
        values = entries(reply)
        model, laser, motor, mode, rate, condition = _words(values, "MODL", "LASR", "SCSP", "MESM", "SBPS", "STAT")
        return cls(model, laser == "ON", motor, mode, rate, decode_hex_time(values.get("TIME", "")), condition)

    def encode(self) -> Reply:
        """Return the answer."""
        return _reply(
            "II",
            MODL=self.model,
            LASR="ON" if self.laser else "OFF",
            SCSP=self.motor,
            MESM=self.mode,
            SBPS=self.bit_rate,
            TIME=encode_hex_time(self.time),
            STAT=self.condition,
        )
