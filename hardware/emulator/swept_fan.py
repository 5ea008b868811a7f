"""The fan of a turning sensor, measured sector by sector."""

from itertools import pairwise
from math import pi
from typing import Final

import numpy as np

from hardware.emulator.plant import Plant
from hardware.scip.information import SensorParameters

SECTORS: Final = 8
"""Number of sectors of the fan. All beams of a sector see the world as it is when the middle beam of the sector
fires."""


class SweptFan:
    """Bearings in the sensor frame, and the newest range at each, nan before the first.

    Indexed by the steps of a whole turn.
    """

    def __init__(self, plant: Plant, now: float, parameters: SensorParameters) -> None:
        self._plant = plant
        self._plant_began = now - plant.elapsed
        self._step_time = parameters.step_time
        measured = parameters.last + 1 - parameters.first
        self._edges = [parameters.first + measured * k // SECTORS for k in range(SECTORS + 1)]
        middles = [(first + end) / 2.0 for first, end in pairwise(self._edges)]
        self.events = [step * parameters.step_time for step in (*middles, self._edges[-1])]
        """Seconds from step 0 to the middle of each sector, and to the end of the fan."""
        self.bearings = (np.arange(parameters.resolution) - parameters.front) * 2.0 * pi / parameters.resolution
        self.ranges = np.full(parameters.resolution, np.nan)

    def sweep(self, sector: int, turn_began: float) -> None:
        """Measure one sector of the turn that began at this time."""
        first, last = self._edges[sector : sector + 2]
        ahead = turn_began + first * self._step_time - self._plant_began - self._plant.elapsed
        self.ranges[first:last] = self._plant.ranges(self.bearings[first:last], ahead, self._step_time)
