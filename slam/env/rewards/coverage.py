"""``coverage``: newly seen area."""

from __future__ import annotations

from slam.env.seen_grid import Extent, SeenGrid
from slam.env.step_state import StepState


class CoverageReward:
    """``a^2 (N[t] - N[t-1])``, m^2, where N cells of side a have been seen: run through by a beam, or met by one.

    The beams are taken from the true pose. What the first scan sees is nobody's merit and counts nothing.
    """

    def __init__(self, extent: Extent, cell: float, first: StepState) -> None:
        self.grid = SeenGrid(extent, cell)
        self.of(first)

    def of(self, moment: StepState) -> float:
        """Square metres newly seen."""
        return self.grid.add(moment.observation.scan, moment.T_map_laser)
