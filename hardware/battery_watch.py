"""Watch of the robot's battery: it warns once when the battery is low, and reports when it is empty."""

import logging
from typing import Final, Literal

from hardware.arcos.config_packet import ArcosConfig
from slam.robot import Battery
from slam.scenario.hardware_config import HardwareConfig

_LOG: Final = logging.getLogger("hopslam.p3dx")
_LASTING: Final = 3.0
"""Seconds for which the voltage must stay low: starting motors pull it down for a moment."""
_BEFORE_SHUTDOWN: Final = 0.2
"""Volts above the voltage at which the robot switches itself off, possibly in motion."""
_NOTHING: Final = 1.0
"""Volts; a lower reading means that the robot reports no voltage."""


class BatteryWatch:
    """Takes the voltages of reports; ``state`` is the newest one with its level, None before the first.

    ``settings`` of the robot's FLASH may raise the limits of the scenario.
    """

    def __init__(self, config: HardwareConfig, settings: ArcosConfig) -> None:
        shutdown = settings.shutdown_voltage
        self._end = (
            max(config.end_battery, shutdown + _BEFORE_SHUTDOWN if shutdown else 0.0) if config.end_battery else 0.0
        )
        self._low = max(config.low_battery, settings.low_battery) if config.low_battery else 0.0
        self._down_since: dict[float, float] = {}
        self._said = False
        self.state: Battery | None = None

    def take(self, stamp: float, volts: float) -> None:
        """Take the voltage of a report, and warn once when it is low."""
        if volts < _NOTHING:
            return
        level: Literal["good", "low", "empty"] = "low" if self._is_down(self._low, stamp, volts) else "good"
        if self._is_down(self._end, stamp, volts):
            level = "empty"
        self.state = Battery(volts, level)
        if level == "low" and not self._said:
            self._said = True
            ends = f"; at {self._end:.1f} V the robot stops" if self._end else ""
            _LOG.warning("the robot's battery is low: %.1f V%s: bring it home and charge it", volts, ends)

    def _is_down(self, limit: float, stamp: float, volts: float) -> bool:
        """Return True if the voltage has been below this limit long enough."""
        if volts >= limit:
            self._down_since.pop(limit, None)
            return False
        return stamp - self._down_since.setdefault(limit, stamp) >= _LASTING
