"""Scores of one policy in a batch, in the kinematic simulator, in PyBullet, and on emulated devices."""

from contextlib import closing
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from hardware.bench.emulated_robot import emulated_devices
from hardware.bench.policy import Policy
from slam.env.ids import ENV_IDS, find_env_id, register_ids
from slam.scenario.file import load_scenario
from slam.scenario.settings import one_or_several


@dataclass(frozen=True, slots=True)
class Score:
    """Outcome of one episode."""

    earned: float
    """Return of the episode: the sum of its rewards."""
    seconds: float
    ending: str


def score_in_batch(policy: Policy, seeds: range) -> list[Score]:
    """Let a batch of robots drive one episode each, with these seeds, each in a world of its own."""
    register_ids()
    batch = {"vectorization_mode": "vector_entry_point", "autoreset_mode": AutoresetMode.NEXT_STEP}
    given = {"worlds": len(seeds)} | dict(policy.arguments) | batch
    envs = gymnasium.make_vec(find_env_id(policy.env_id), num_envs=len(seeds), **given)
    scores: list[Score | None] = [None] * len(seeds)
    with closing(envs):
        observation, _ = envs.reset(seed=seeds[0])
        earned = np.zeros(len(seeds))
        while None in scores:
            observation, rewards, terminated, truncated, info = envs.step(policy(observation))
            earned += rewards
            for k in np.flatnonzero(terminated | truncated):
                if scores[k] is None:
                    scores[k] = Score(float(earned[k]), float(info["seconds"][k]), str(info["ending"][k]))
    return [score for score in scores if score is not None]


def score_alone(policy: Policy, seeds: range, engine: str) -> list[Score]:
    """Let one robot with this ``physics.engine`` drive an episode with each of these seeds."""
    with closing(_make(policy, f"physics.engine={engine}")) as env:
        return [_episode(env, policy, seed) for seed in seeds]


def score_on_devices(policy: Policy, seeds: range, plant: str) -> list[Score]:
    """Let emulated devices, moved by this plant, drive an episode with each of these seeds, in real time."""
    scores = []
    for seed in seeds:
        settings = [*one_or_several(policy.arguments.get("settings", ())), f"seed={seed}"]
        scenario = load_scenario(_scenario_of(policy), settings)
        with emulated_devices(scenario, plant=plant) as emulator, emulator:
            ports = [f"seed={seed}", *emulator.port_settings]
            with closing(_make(policy, *ports, backend="hardware", yes=True)) as env:
                scores.append(_episode(env, policy, seed))
    return scores


def _make(policy: Policy, *settings: str, **more: Any) -> gymnasium.Env[Any, Any]:
    """Make the policy's environment, with extra settings."""
    register_ids()
    given = dict(policy.arguments) | more
    given["settings"] = [*one_or_several(policy.arguments.get("settings", ())), *settings]
    return gymnasium.make(find_env_id(policy.env_id), **given)


def _scenario_of(policy: Policy) -> str:
    return ENV_IDS[find_env_id(policy.env_id)] or str(policy.arguments.get("scenario", "corridor"))


def _episode(env: gymnasium.Env[Any, Any], policy: Policy, seed: int) -> Score:
    observation, _ = env.reset(seed=seed)
    earned, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation))
        earned, over = earned + float(reward), terminated or truncated
    return Score(earned, float(info["seconds"]), str(info["ending"]))
