"""Policies, each with its environment."""

from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from slam.errors import InputError, did_you_mean
from slam.named_code import call, find_code

_SPEED, _TURN_SPEED = 0.5, 0.8
"""Largest speeds that the policy ``goal`` asks for, m/s and rad/s."""


class Policy(Protocol):
    """Chooses the actions of one robot or of many at once; the class is called without arguments."""

    env_id: str
    """Id of its environment, one of ``hopslam env``."""
    arguments: Mapping[str, Any]
    """Arguments of the environment: views, reward, ends, settings."""

    def __call__(self, observation: dict[str, NDArray[Any]], /) -> NDArray[Any]:
        """Choose the action (2,) of one robot, or the actions (N, 2) of N robots, whose arrays have a leading axis."""
        ...


class GoalPolicy:
    """Turns towards the next way-point, and slows down before it."""

    env_id = "hopslam/Corridor-v0"
    arguments: Mapping[str, Any] = {"observe": "goal", "max_seconds": 20.0}

    def __call__(self, observation: dict[str, NDArray[Any]], /) -> NDArray[np.float32]:
        distance, bearing = np.moveaxis(observation["goal"], -1, 0)
        v = np.clip(distance - 0.1, 0.05, _SPEED) * np.maximum(np.cos(bearing), 0.0)
        return np.stack([v, np.clip(1.5 * bearing, -_TURN_SPEED, _TURN_SPEED)], axis=-1).astype(np.float32)


POLICIES: Final[dict[str, Callable[[], Policy]]] = {"goal": GoalPolicy}
"""The built-in policies, by name."""


def make_policy(name: str) -> Policy:
    """Make the policy with this name, or of a class named ``module:Class``."""
    if name in POLICIES:
        return POLICIES[name]()
    if ":" not in name:
        hint = did_you_mean(name, POLICIES, otherwise=f"choose {', '.join(POLICIES)}, or give module:Class")
        raise InputError(f"no policy {name!r}; {hint}")
    policy = call(name, find_code(name, (name,)))
    for part in ("env_id", "arguments", "__call__"):
        if not hasattr(policy, part):
            raise InputError(f"{name}: a policy has env_id, arguments and __call__(observation); {part} is missing")
    return cast(Policy, policy)
