"""The settings of an emulated SCIP sensor, which commands change."""

from dataclasses import dataclass
from typing import Final

from hardware.scip.commands import ScanRequest
from hardware.scip.information import SensorParameters

DEFAULT_BAUD: Final = 19200


@dataclass(slots=True)
class SensorSettings:
    """The settings, as they are when the sensor gets power."""

    parameters: SensorParameters
    last_step: int
    """The last step that may be asked for; those behind ``parameters.last`` are not measured."""
    time: float = 0.0
    """Seconds of the sensor's clock."""
    scip2: bool = False
    laser: bool = False
    baud: int = DEFAULT_BAUD
    streaming: ScanRequest | None = None
    """Request for the scans that come by themselves; its ``scans`` are left, 0 for no end."""
    note: str = ""
    """Note that the client appended to the command that began them."""
    adjusting: bool = False
    """True between TM0 and TM2."""

    def stop(self) -> None:
        """Switch the laser off, which ends the scans."""
        self.laser, self.streaming = False, None
