"""``progress``: metres of the route."""

from __future__ import annotations

from slam.env.step_state import StepState


class ProgressReward:
    """``L[t-1] - L[t]``, metres, where L is the straight way from the true position through all way-points left.

    Driving away costs as much as coming back earns; over an episode the sum is ``L[0] - L[T]``.
    """

    def __init__(self, first: StepState) -> None:
        self._left = first.left

    def of(self, moment: StepState) -> float:
        """Metres gained since the last moment."""
        before, self._left = self._left, moment.left
        return before - self._left
