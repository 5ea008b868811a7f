"""A task for an agent: see as much as it can of an office. The environment, and a policy written by hand."""

from collections.abc import Sequence

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.wrappers import TransformObservation

SECTORS, REACH = 16, 4.0  # m: as far as the lidar of the paper's Table 1 sees


def explorer(settings: Sequence[str] = ("lidar.model=table1",), **robot: object) -> gymnasium.Env:
    """40 s in an office, paid by the square metre seen; running into something costs 10 m^2 and ends it.

    Simulated, it is a new office in every episode, seen by a coarse lidar, which is fast. ``robot`` may say otherwise:
    ``backend="hardware"``.
    """
    task = {"reward": "coverage", "collision_penalty": 10.0, "end_on": "collision", "max_seconds": 40.0}
    env = gymnasium.make("sim:hopslam/RandomOffice-v0", settings=settings, **task, **robot)
    return TransformObservation(env, sectors, Box(-np.inf, np.inf, (SECTORS + 2,), np.float32))


def sectors(observation: dict[str, np.ndarray]) -> np.ndarray:
    """The nearest echo in each of 16 sectors, from right to left, as a share of the reach; then v and omega.

    It is the same for every lidar that sees 240 degrees, however many beams it has.
    """
    nearest = [min(part.min(), REACH) / REACH for part in np.array_split(observation["scan"], SECTORS)]
    return np.concatenate([nearest, observation["odometry"][3:]], dtype=np.float32)


class ByHand:
    """The rival of a learnt policy: turn to where there is most space, as fast as the space ahead allows."""

    def predict(self, seen: np.ndarray, deterministic: bool = True) -> tuple[np.ndarray, None]:
        """The action, and no state, as Stable-Baselines3 has it."""
        space = np.convolve(seen[:SECTORS], [0.25, 0.5, 0.25], "same")
        turn = np.linspace(-1.0, 1.0, SECTORS)[space.argmax()]
        return np.array([np.clip(1.2 * seen[5:11].min() - 0.2, 0.0, 1.0), turn], np.float32), None
