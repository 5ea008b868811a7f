"""What an agent is paid for, by name."""

from __future__ import annotations

from typing import Protocol

from slam.run.env.config import EnvConfig
from slam.run.env.moment import Moment
from slam.run.env.rewards.coverage import CoverageReward
from slam.run.env.rewards.no_reward import NoReward
from slam.run.env.rewards.progress import ProgressReward
from slam.run.env.seen_grid import Extent


class Reward(Protocol):
    """Of one episode; made from its first moment."""

    def of(self, moment: Moment) -> float:
        """What the step that led to this moment is worth."""
        ...


def make_reward(config: EnvConfig, extent: Extent, first: Moment) -> Reward:
    """The reward that the configuration names."""
    if config.reward == "progress":
        return ProgressReward(first)
    if config.reward == "coverage":
        return CoverageReward(extent, config.cell, first)
    return NoReward()
