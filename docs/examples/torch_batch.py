"""The arrays of a batch as PyTorch tensors, without a copy: a network drives 1024 robots.

    pip install 'hopslam[rl]'
    python docs/examples/torch_batch.py

Every step returns new arrays, so a tensor that shares the memory of an old one does not change.
"""

import sys
from time import perf_counter

import gymnasium

try:
    import torch
except ImportError as error:
    print("torch_batch.py needs PyTorch: pip install 'hopslam[rl]'", file=sys.stderr)
    raise SystemExit(2) from error

ROBOTS, STEPS = 1024, 100


def main() -> None:
    """Let an untrained network drive, and say how many steps a second that is."""
    batch = {"vectorization_mode": "vector_entry_point", "autoreset_mode": "SameStep"}
    envs = gymnasium.make_vec("sim:hopslam/Corridor-v0", num_envs=ROBOTS, **batch)
    beams = envs.single_observation_space["scan"].shape[0]
    network = torch.nn.Sequential(torch.nn.Linear(beams, 64), torch.nn.Tanh(), torch.nn.Linear(64, 2), torch.nn.Tanh())
    observation, _ = envs.reset(seed=0)
    began, earned = perf_counter(), torch.zeros(ROBOTS, dtype=torch.float64)
    with torch.inference_mode():
        for _ in range(STEPS):
            scans = torch.from_numpy(observation["scan"])  # the same memory
            assert scans.data_ptr() == observation["scan"].ctypes.data
            observation, rewards, *_ = envs.step(network(scans).numpy())
            earned += torch.from_numpy(rewards)
    print(f"{ROBOTS * STEPS / (perf_counter() - began):.0f} steps a second; {earned.mean():.2f} m a robot")
    envs.close()


if __name__ == "__main__":
    main()
