"""Rewards of an agent, by name."""

from collections.abc import Callable
from typing import Final

from slam.env.occupancy_grid import Extent, OccupancyGrid
from slam.env.step_state import StepState

Reward = Callable[[StepState], float]
"""The reward of the step that led to a state, in one episode; called once for each."""


def progress_reward(first: StepState, extent: Extent, cell: float) -> Reward:
    """``L[t-1] - L[t]``, metres.

    L is the length of the straight path from the true position through all way-points left. Driving away costs as much
    as coming back earns; over an episode the sum is ``L[0] - L[T]``.
    """
    left = first.route_left

    def gained(state: StepState) -> float:
        nonlocal left
        before, left = left, state.route_left
        return before - left

    return gained


def coverage_reward(first: StepState, extent: Extent, cell: float) -> Reward:
    """``a^2 (N[t] - N[t-1])``, m^2, where N cells of side a have been seen: spanned by beams, or hit by one.

    The beams start at the true pose. The cells of the first scan do not count.
    """
    grid = OccupancyGrid(extent, cell)

    def newly_seen(state: StepState) -> float:
        return grid.add_scan(state.observation.scan, state.T_map_laser)

    newly_seen(first)
    return newly_seen


def no_reward(first: StepState, extent: Extent, cell: float) -> Reward:
    """Always 0: for control without learning, or with a custom reward."""
    return lambda state: 0.0


REWARDS: Final[dict[str, Callable[[StepState, Extent, float], Reward]]] = {
    "progress": progress_reward,
    "coverage": coverage_reward,
    "none": no_reward,
}
"""Every reward by its name in the argument ``reward``; made from the first state of an episode, the extent of its
world, and the side of a cell, metres."""
