"""The settings of an emulated SCIP sensor, which commands change."""

from dataclasses import dataclass
from typing import Final

from hardware.scip.commands import ScanRequest
from hardware.scip.information import SensorParameters

DEFAULT_BAUD: Final = 19200


@dataclass(slots=True)
class SensorSettings:
    """Settings of the sensor; the defaults are those at power-up."""

    parameters: SensorParameters
    last_step: int
    """Last step that may be requested; those behind ``parameters.last`` are not measured."""
    time: float = 0.0
    """Seconds of the sensor's clock."""
    scip2: bool = False
    laser: bool = False
    baud: int = DEFAULT_BAUD
    streaming: ScanRequest | None = None
    """Request for continuous scans; its ``scans`` are those left to send, 0 for no end."""
    note: str = ""
    """String that the client appended to the command that began the scans."""
    adjusting: bool = False
    """True between TM0 and TM2."""

    def stop(self) -> None:
        """Switch the laser off, which ends the scans."""
        self.laser, self.streaming = False, None
