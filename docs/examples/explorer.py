"""A task for an agent, to see as much of an office as possible: its environment, and a policy written by hand."""

from collections.abc import Sequence

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.wrappers import TransformObservation

ID, COARSE = "sim:hopslam/RandomOffice-v0", ("lidar.model=table1",)
TASK = {"reward": "coverage", "collision_penalty": 10.0, "end_on": "collision", "max_seconds": 40.0}
SECTORS, REACH = 16, 4.0  # m: as far as the lidar of the paper's Table 1 sees
SPACE = Box(-np.inf, np.inf, (SECTORS + 2,), np.float32)


def explorer(settings: Sequence[str] = COARSE, **robot: object) -> gymnasium.Env:
    """Make the environment: 40 s in an office, with the area seen as the reward; a collision costs 10 m^2 and ends it.

    Every episode has a new simulated office; the lidar is coarse, for speed. ``robot`` are further arguments, such as
    ``backend="hardware"``.
    """
    env = gymnasium.make(ID, settings=settings, **TASK, **robot)
    return TransformObservation(env, sectors, SPACE)


def explorers(count: int, offices: int) -> VectorEnv:
    """Make ``count`` robots, moved without PyBullet; each episode takes place in one of ``offices`` offices."""
    batch = {"vectorization_mode": "vector_entry_point", "autoreset_mode": AutoresetMode.SAME_STEP}
    return gymnasium.make_vec(ID, num_envs=count, settings=COARSE, worlds=offices, **TASK, **batch)


def sectors(observation: dict[str, np.ndarray]) -> np.ndarray:
    """The nearest echo in each of 16 sectors, from right to left, as a share of the reach; then v and omega.

    It is the same for every lidar that sees 240 degrees, however many beams it has, and for one robot or many.
    """
    nearest = [part.min(axis=-1) for part in np.array_split(observation["scan"], SECTORS, axis=-1)]
    shares = np.minimum(np.stack(nearest, axis=-1), REACH) / REACH
    return np.concatenate([shares, observation["odometry"][..., 3:]], axis=-1, dtype=np.float32)


class ByHand:
    """The rival of a learnt policy: turn to where there is most space, as fast as the space ahead allows."""

    env_id, arguments = ID.removeprefix("sim:"), TASK | {"settings": COARSE}

    def __call__(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        """The action for the observation of one robot, or of many: for ``hopslam bench policy``."""
        return self.predict(sectors(observation))[0]

    def predict(self, seen: np.ndarray, deterministic: bool = True) -> tuple[np.ndarray, None]:
        """The action, and None for a state, the form in which a policy of Stable-Baselines3 answers."""
        space = np.apply_along_axis(np.convolve, -1, seen[..., :SECTORS], [0.25, 0.5, 0.25], "same")
        turn = np.linspace(-1.0, 1.0, SECTORS)[space.argmax(axis=-1)]
        ahead = np.clip(1.2 * seen[..., 5:11].min(axis=-1) - 0.2, 0.0, 1.0)
        return np.stack([ahead, turn], axis=-1).astype(np.float32), None
