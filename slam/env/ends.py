"""When an episode ends, and why."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from slam.env.config import EndName, EnvConfig
from slam.env.step_state import StepState

_ENDS: Final[dict[EndName, Callable[[StepState, EnvConfig], bool]]] = {
    "collision": lambda moment, config: moment.collided,
    "goal": lambda moment, config: moment.arrived,
    "lost": lambda moment, config: moment.lost or moment.slam_error > config.lost_beyond,
}


def termination(moment: StepState, config: EnvConfig) -> str:
    """The first of the ends asked for that has come, as ``end_on`` orders them; "" while there is none."""
    return next((name for name in config.end_on if _ENDS[name](moment, config)), "")
