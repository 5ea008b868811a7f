"""``none``: for control without learning, or a reward of one's own."""

from __future__ import annotations

from slam.run.env.moment import Moment


class NoReward:
    """Always 0."""

    def of(self, moment: Moment) -> float:
        """0."""
        return 0.0
