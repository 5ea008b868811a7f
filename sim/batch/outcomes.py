"""Rewards, ends and ``info`` of a batch, from the results of a step."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from sim.batch.robots import BatchObservation, Robots
from sim.batch.worlds import Timing
from slam.env.config import EnvConfig
from slam.pose import FloatArray

ENDINGS: Final = ("", "collision", "goal", "lost", "time")
TIME: Final = 4


def reward_terms(seen: BatchObservation, config: EnvConfig, begins: NDArray[np.bool_]) -> dict[str, FloatArray]:
    """Terms whose sum is the reward, (N,) each; 0 for the first scan of an episode."""
    metres, cells = seen.gained.T
    gained = {"progress": metres, "coverage": config.cell**2 * cells, "none": 0.0 * metres}
    hit = (seen.collided | seen.stalled) & ~begins
    return {config.reward: gained[config.reward], "collision": -config.collision_penalty * hit}


def endings(
    seen: BatchObservation, config: EnvConfig, begins: NDArray[np.bool_], lost: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Index in ENDINGS of the first end of ``end_on`` that is true, (N,)."""
    come = {"collision": seen.collided | seen.stalled, "goal": seen.arrived, "lost": lost}
    ending = np.zeros(len(begins), np.int64)
    for name in reversed(config.end_on):
        ending[come[name] & ~begins] = ENDINGS.index(name)
    return ending


def batch_info(
    of: NDArray[np.bool_], robots: Robots, seen: BatchObservation, timing: Timing,
    terms: dict[str, FloatArray], ending: NDArray[np.int64], slam: dict[str, NDArray[Any]],
) -> dict[str, Any]:  # fmt: skip
    """Make the ``info`` of these robots: copied arrays of all robots, each with a mask of the robots it is valid for.

    The masks are named ``_key``, as in gymnasium. ``slam`` has the keys that SLAM adds.
    """
    info: dict[str, Any] = {
        "T_map_base": seen.pose.copy(),
        "pose": seen.pose.copy(),
        "pose_from": np.full(len(of), "truth"),
        "collided": seen.collided.copy(),
        "stalled": seen.stalled.copy(),
        "applied": seen.applied.copy(),
        "stamp": (robots.turns - 1) * timing.scan_time + timing.controls_before * timing.period,
        "seconds": robots.turns * timing.scan_time,
        "route_left": robots.left.copy(),
        "reward": {name: term.copy() for name, term in terms.items()} | {f"_{name}": of.copy() for name in terms},
        "ending": np.array(ENDINGS)[ending],
    } | {key: rows.copy() for key, rows in slam.items()}
    return info | {f"_{key}": of.copy() for key in info}
