"""PPO learns to explore offices, a new one in every episode.

    pip install 'hopslam[rl]'
    python docs/examples/train.py

256 robots learn at once in the kinematic simulator; the policy is then scored in PyBullet. Training takes a few minutes
on two cores, and writes policy.zip, a log of the episodes and curve.png into runs/train. `--steps 50000` is a quick
try. drive.py lets the policy drive, and learnt.py prepares it for `hopslam bench policy`.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Annotated

import numpy as np
import typer
from explorer import SPACE, ByHand, explorer, explorers, sectors
from matplotlib.figure import Figure

try:
    import torch
    from batch_vec_env import BatchVecEnv
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor
    from tqdm import tqdm
except ImportError as error:
    print("train.py needs stable-baselines3: pip install 'hopslam[rl]'", file=sys.stderr)
    raise SystemExit(2) from error

OUT = Path("runs/train")


def score(name: str, policy: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Returns of 40 episodes in offices that nobody trained on."""
    env, returns = explorer(), np.zeros(40)
    for k in tqdm(range(len(returns)), f"{name}, 40 unseen offices"):
        (seen, _), over = env.reset(seed=1_000_000 + k), False
        while not over:
            seen, reward, terminated, truncated, _ = env.step(policy(seen))
            returns[k] += reward
            over = terminated or truncated
    env.close()
    return returns


def draw(log: Path, rivals: dict[str, float]) -> None:
    """The return of each training episode over the steps, and its mean over 50 episodes."""
    returns, lengths, _ = np.genfromtxt(log, delimiter=",", skip_header=2, ndmin=2).T
    mean = np.convolve(returns, np.ones(50) / 50, "full")[49 : len(returns)]  # the mean begins at episode 50
    axes = (figure := Figure((8, 4), dpi=120, layout="constrained")).add_subplot()
    axes.plot(lengths.cumsum(), returns, ".", color="0.7", label="a training episode")
    axes.plot(lengths.cumsum()[49:], mean, label="mean of the last 50")
    for style, (name, value) in zip((":", "--", "-."), rivals.items(), strict=True):
        axes.axhline(value, color="k", ls=style, lw=1, label=f"{name}, unseen offices: {value:.1f}")
    axes.set(xlabel="environment steps of 0.1 s", ylabel="return: newly seen m² - penalty")
    axes.legend(fontsize="small")
    figure.savefig(OUT / "curve.png")


def train(
    steps: Annotated[int, typer.Option(min=1, help="Steps of all robots together.")] = 500_000,
    robots: Annotated[int, typer.Option(min=1, help="Robots that learn at once.")] = 256,
) -> None:
    """Train, save the policy, and compare it with random actions and with a policy written by hand."""
    OUT.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)  # for so small a network, threads wait for each other
    envs = VecMonitor(BatchVecEnv(explorers(robots, offices=64), sectors, SPACE), str(OUT / "episodes"))
    model = PPO("MlpPolicy", envs, n_steps=64, batch_size=2048, use_sde=True, sde_sample_freq=8, seed=0, device="cpu")
    began = perf_counter()
    model.learn(steps, progress_bar=True)
    print(f"{steps} steps in {perf_counter() - began:.0f} s")
    envs.close()
    model.save(OUT / "policy")
    sampler = explorer().action_space
    scores = {"random": score("random", lambda seen: sampler.sample())}
    for name, policy in {"by hand": ByHand(), "learnt": model}.items():
        scores[name] = score(name, lambda seen, policy=policy: policy.predict(seen, deterministic=True)[0])
    for name, returns in scores.items():
        print(f"{name}: {returns.mean():.1f} m^2 on average, {returns.min():.1f} to {returns.max():.1f}")
    draw(OUT / "episodes.monitor.csv", {name: returns.mean() for name, returns in scores.items()})


if __name__ == "__main__":
    typer.run(train)
