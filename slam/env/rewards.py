"""Rewards of an agent, by name."""

from collections.abc import Callable
from typing import Final, Protocol

from slam.env.occupancy_grid import Extent, OccupancyGrid
from slam.env.step_state import StepState


class Reward(Protocol):
    """The reward of one episode, made from the state after its first scan."""

    def of(self, state: StepState) -> float:
        """Reward the step that led to this state."""
        ...


class ProgressReward:
    """``L[t-1] - L[t]``, metres, where L is the straight way from the true position through all way-points left.

    Driving away costs as much as coming back earns; over an episode the sum is ``L[0] - L[T]``.
    """

    def __init__(self, first: StepState) -> None:
        self._left = first.route_left

    def of(self, state: StepState) -> float:
        """Metres gained since the last state."""
        before, self._left = self._left, state.route_left
        return before - self._left


class CoverageReward:
    """``a^2 (N[t] - N[t-1])``, m^2, where N cells of side a have been seen: run through by a beam, or met by one.

    The beams are taken from the true pose. What the first scan sees is nobody's merit and counts nothing.
    """

    def __init__(self, first: StepState, extent: Extent, cell: float) -> None:
        self._grid = OccupancyGrid(extent, cell)
        self.of(first)

    def of(self, state: StepState) -> float:
        """Square metres newly seen."""
        return self._grid.add_scan(state.observation.scan, state.T_map_laser)


class NoReward:
    """Always 0: for control without learning, or a reward of one's own."""

    def of(self, state: StepState) -> float:
        """0."""
        return 0.0


REWARDS: Final[dict[str, Callable[[StepState, Extent, float], Reward]]] = {
    "progress": lambda first, extent, cell: ProgressReward(first),
    "coverage": CoverageReward,
    "none": lambda first, extent, cell: NoReward(),
}
"""Every reward by the name that the argument ``reward`` gives it; made from the first state of an episode, the extent
of its world, and the side of a cell, metres."""
