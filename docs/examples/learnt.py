"""The policy that train.py has learnt, for the command that scores policies.

    PYTHONPATH=docs/examples hopslam bench policy learnt:Learnt --episodes 40

`explorer:ByHand` instead of `learnt:Learnt` scores the policy that is written by hand.
"""

import numpy as np
from explorer import COARSE, ID, TASK, sectors
from stable_baselines3 import PPO


class Learnt:
    """The trained policy, for the observations of one robot or of many."""

    env_id, arguments = ID.removeprefix("sim:"), TASK | {"settings": COARSE}

    def __init__(self) -> None:
        self.model = PPO.load("runs/train/policy", device="cpu")

    def __call__(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        """The most likely action."""
        return self.model.predict(sectors(observation), deterministic=True)[0]
