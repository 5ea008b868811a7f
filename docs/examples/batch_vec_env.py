"""A batch of robots as Stable-Baselines3 takes it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from gymnasium.vector import VectorEnv
from stable_baselines3.common.vec_env import VecEnv


class BatchVecEnv(VecEnv):
    """Wraps ``gymnasium.make_vec(..., vectorization_mode="vector_entry_point", autoreset_mode="SameStep")``.

    ``see`` converts an observation, of one robot or of all, to the input of the policy, whose space for one robot is
    ``space``.
    """

    def __init__(self, envs: VectorEnv, see: Callable[[dict[str, np.ndarray]], np.ndarray], space: Space) -> None:
        super().__init__(envs.num_envs, space, envs.single_action_space)
        self.envs, self.see = envs, see

    def reset(self) -> np.ndarray:
        """Begin an episode with every robot."""
        observation, _ = self.envs.reset(seed=self._seeds)
        self._reset_seeds()
        return self.see(observation)

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions of the next step."""
        self.actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all robots; those whose episode ended are at the start of their next one."""
        observation, rewards, terminated, truncated, info = self.envs.step(self.actions)
        over, infos = terminated | truncated, [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(over):
            last = self.see(info["final_obs"][k])
            infos[k] = {"terminal_observation": last, "TimeLimit.truncated": bool(truncated[k] and not terminated[k])}
        return self.see(observation), rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """Close the environment of all robots."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return the attribute of the batch for each of these robots."""
        return [getattr(self.envs, attr_name, None) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refused: the robots of a batch have no attributes of their own."""
        raise NotImplementedError("the robots of a batch have no attributes of their own")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Refused: the robots of a batch have no methods of their own."""
        raise NotImplementedError("the robots of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: type, indices: Sequence[int] | None = None) -> list[bool]:
        """Return False for each robot: a batch has no wrappers of single robots."""
        return [False for _ in self._get_indices(indices)]
