"""``none``: for control without learning, or a reward of one's own."""

from __future__ import annotations

from slam.env.step_state import StepState


class NoReward:
    """Always 0."""

    def of(self, moment: StepState) -> float:
        """0."""
        return 0.0
