"""What an agent is paid for, by name."""

from __future__ import annotations

from typing import Protocol

from slam.env.config import EnvConfig
from slam.env.rewards.coverage import CoverageReward
from slam.env.rewards.no_reward import NoReward
from slam.env.rewards.progress import ProgressReward
from slam.env.seen_grid import Extent
from slam.env.step_state import StepState


class Reward(Protocol):
    """Of one episode; made from its first moment."""

    def of(self, moment: StepState) -> float:
        """What the step that led to this moment is worth."""
        ...


def make_reward(config: EnvConfig, extent: Extent, first: StepState) -> Reward:
    """The reward that the configuration names."""
    if config.reward == "progress":
        return ProgressReward(first)
    if config.reward == "coverage":
        return CoverageReward(extent, config.cell, first)
    return NoReward()
