"""Findings of the doctor: a device at a port, in words."""

from dataclasses import dataclass

from hardware.usb_serial import latency_timer
from slam.lidars import LidarName
from slam.scan import LaserScan


@dataclass(frozen=True, slots=True)
class Finding:
    """A device found at a port, in words."""

    port: str
    words: str
    answered: bool = True
    faults: tuple[str, ...] = ()
    """Reasons that keep the device from use, each with the next step."""
    scan: LaserScan | None = None
    """One scan, from a lidar that measures."""
    model: LidarName = "urg04lx"
    """Model of the lidar."""

    @property
    def fine(self) -> bool:
        """True if a device answers and nothing is wrong with it."""
        return self.answered and not self.faults

    @property
    def advice(self) -> str | None:
        """Advice that makes the device's line faster; None if there is none."""
        timer = latency_timer(self.port) if self.answered else None
        return timer.advice if timer else None
