"""The devices of a real robot: their ports and settings."""

from typing import Annotated, Final, Literal

from pydantic import AfterValidator, Field

from slam.config import Section
from slam.scenario.values import Positive

FIRMWARE_TRACK: Final = 0.357
"""Distance between the wheels that a P3-DX's firmware assumes, metres (DiffConvFactor in Aria's p3dx.p)."""


_URLS: Final = ("socket", "rfc2217", "loop")
"""Prefixes of the URLs of pyserial that reach a device and write no file."""


def _port(name: str) -> str:
    kind, url, _ = name.partition("://")
    if url and kind not in _URLS:
        urls = ", ".join(f"{kind}://" for kind in _URLS)
        raise ValueError(f"a port is a device such as /dev/ttyUSB0 or COM3, or {urls}")
    return name


Port = Annotated[str, AfterValidator(_port)]


Voltage = Annotated[float, Field(ge=0, le=60)]


class FlashSettings(Section):
    """Settings in the FLASH of the robot, for one whose CONFIG packet is missing, damaged, or short."""

    watchdog: Positive = 2.0
    """Seconds without a command after which the robot stops by itself."""
    ticks_per_metre: Positive | None = None
    """Ticks of the wheel encoders per metre; without it they are unknown, and odometry=encoders is refused."""
    front_bumpers: int = Field(0, ge=0, le=7)
    """Number of segments of the front bumper."""
    rear_bumpers: int = Field(0, ge=0, le=7)
    """Number of segments of the rear bumper."""


class HardwareConfig(Section):
    """Devices that ``--backend hardware`` opens.

    A port is a device (``/dev/ttyUSB0``, on macOS ``/dev/cu.usbserial-1410``, on Windows ``COM3``),
    ``socket://host:port``, ``rfc2217://host:port``, ``loop://``, or ``wire:FILE#port``, which plays a recording of
    --record-wire.
    """

    robot_port: Port = "/dev/ttyUSB0"
    """Serial port of the P3-DX."""
    lidar_port: Port = "/dev/ttyACM0"
    """Serial port of the lidar."""
    lidar_baud: Literal[19200, 38400, 57600, 115200, 250000, 500000, 750000] = 500000
    """Bit rate of a URG-04LX; below 250000 an RS-232 line is too slow for ten full scans per second. Over USB it has no
    effect."""
    drive_by: Literal["velocity", "wheels"] = "velocity"
    """Commands for the base in steps of 1 mm/s and 1 deg/s, or for each wheel in steps of 20 mm/s."""
    odometry: Literal["position", "encoders"] = "position"
    """Source of the odometry: the position that the robot's firmware computes, or the ticks of its wheels."""
    left_scale: Positive = 1.0
    """Metres that the left wheel really rolls per metre that the robot reports; hopslam calibrate finds it."""
    right_scale: Positive = 1.0
    """Metres that the right wheel really rolls per metre that the robot reports; hopslam calibrate finds it."""
    track_scale: Positive = 1.0
    """Effective wheel track per metre of the track that the robot assumes; hopslam calibrate finds it."""
    command_timeout: float = Field(0.5, gt=0, le=2)
    """Time without a new command, seconds, after which the robot stops."""
    data_timeout: float = Field(0.3, gt=0.15, le=2)
    """Time without a scan or odometry, seconds, after which the robot stops; for scans at least three scan periods."""
    low_battery: Voltage = 11.5
    """Voltage below which a run warns of a low battery; a higher limit in the robot's FLASH has priority; volts, 0:
    never."""
    end_battery: Voltage = 11.0
    """Voltage below which the robot stops and the run ends; at least 0.2 V above that at which the robot switches
    itself off; volts, 0: never."""
    patience: float = Field(30.0, ge=0)
    """Time that a run waits at rest for a silent lidar or base before it ends, seconds."""
    max_watchdog: Positive = 2.0
    """Longest watchdog of the robot that is accepted, seconds; the watchdog is set in its FLASH."""
    settings: FlashSettings = FlashSettings()
    """Settings in the robot's FLASH, if it does not report them."""
