"""Checks of the arguments of a batch; InputError is one line that names the fault."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from slam.env.config import EnvConfig
from slam.errors import InputError, did_you_mean
from slam.pose import FloatArray


def check_arguments(config: EnvConfig, slam: bool, render_mode: str | None, **numbers: int | None) -> None:
    """Refuse arguments that a batch cannot use, and numbers below 1."""
    if not slam and ("slam_pose" in config.observe or "lost" in config.end_on):
        raise InputError("a batch runs SLAM only if told: add slam=True, or leave slam_pose and lost out")
    if slam and not config.uses_slam:
        raise InputError("slam=True: nothing here needs SLAM; add slam_pose or map to observe, or lost to end_on")
    for name, number in numbers.items():
        if number is not None and number < 1:
            raise InputError(f"{name}={number}: give 1 or more")
    if render_mode is not None:
        raise InputError(f"render_mode={render_mode!r}: a batch draws nothing; gymnasium.make draws one robot")


def read_autoreset_mode(given: str | AutoresetMode) -> AutoresetMode:
    """Read the autoreset mode, or its name."""
    names = [mode.value for mode in AutoresetMode]
    if given not in (*names, *AutoresetMode):
        hint = did_you_mean(str(given), names, otherwise=f"choose one of {', '.join(names)}")
        raise InputError(f"autoreset_mode={given!r}; {hint}")
    return AutoresetMode(given)


def read_reset_mask(options: dict[str, Any] | None, count: int) -> NDArray[np.bool_]:
    """Read the option ``reset_mask``: a mask (N,) of the robots to reset."""
    given = options or {}
    for key in given:
        if key != "reset_mask":
            raise InputError(f"options: no option {key!r}; the only option of a batch is reset_mask")
    mask = np.asarray(given.get("reset_mask", np.ones(count, np.bool_)))
    if mask.shape != (count,) or mask.dtype != np.bool_:
        raise InputError(f"options: reset_mask: give {count} booleans; these are {mask.shape} of {mask.dtype}")
    return mask


def read_seeds(seed: int | Sequence[int | None] | None, count: int) -> tuple[NDArray[np.uint64], NDArray[np.bool_]]:
    """Read the seeds of ``count`` robots, and which robots have one: k stands for k, k + 1, ..."""
    if seed is None:
        return np.zeros(count, np.uint64), np.zeros(count, np.bool_)
    seeds = [seed + k for k in range(count)] if isinstance(seed, int | np.integer) else list(seed)
    if len(seeds) != count:
        raise InputError(f"seed: give one for each of the {count} robots; these are {len(seeds)}")
    if any(one is not None and one < 0 for one in seeds):
        raise InputError(f"seed: give numbers of 0 or more; the least of these is {min(one for one in seeds if one)}")
    return np.array([one or 0 for one in seeds], np.uint64), np.array([one is not None for one in seeds])


def read_commands(actions: NDArray[Any], config: EnvConfig, tracks: FloatArray) -> FloatArray:
    """Read actions (N, 2) as v and omega; ``tracks`` (N,) are the wheel tracks of the robots, metres."""
    numbers = np.asarray(actions, np.float64)
    if numbers.shape != (len(tracks), 2):
        raise InputError(f"actions have the shape ({len(tracks)}, 2); these have {numbers.shape}")
    if not np.isfinite(numbers).all():
        robot = int(np.flatnonzero(~np.isfinite(numbers).all(axis=1))[0])
        raise InputError(f"actions are finite numbers; that of robot {robot} is {numbers[robot].tolist()}")
    if config.action == "twist":
        return numbers
    left, right = numbers.T
    return np.column_stack([(left + right) / 2.0, (right - left) / tracks])
