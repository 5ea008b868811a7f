"""PPO learns to see as much as it can of an office that is another one in every episode.

    pip install 'hopslam[rl]'
    python docs/examples/train.py

Ten to twenty minutes on two cores; writes policy.zip, a log of the episodes and curve.png into runs/train.
"""

from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.wrappers import TransformObservation
from matplotlib.figure import Figure
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import SubprocVecEnv

OUT, STEPS = Path("runs/train"), 100_000
SECTORS, REACH = 16, 4.0  # the lidar of the paper's Table 1: 128 beams over 240 degrees, 4 m


def explorer() -> gymnasium.Env:
    """40 s in a new office, paid by the square metre seen; running into something costs 10 m^2 and ends it."""
    task = {"reward": "coverage", "collision_penalty": 10.0, "end_on": ["collision"], "max_seconds": 40.0}
    env = gymnasium.make("sim:hopslam/RandomOffice-v0", settings=["lidar.model=table1"], **task)
    return TransformObservation(env, sectors, Box(-np.inf, np.inf, (SECTORS + 2,), np.float32))


def sectors(observation: dict[str, np.ndarray]) -> np.ndarray:
    """The nearest echo in each of 16 sectors, from right to left, as a share of the reach; then v and omega."""
    nearest = observation["scan"].reshape(SECTORS, -1).min(axis=1) / REACH
    return np.concatenate([nearest, observation["odometry"][3:]], dtype=np.float32)


def by_hand(seen: np.ndarray) -> np.ndarray:
    """The rival: turn to where there is most space, and be as fast as the space ahead allows."""
    space = np.convolve(seen[:SECTORS], [0.25, 0.5, 0.25], "same")
    turn = np.linspace(-1.0, 1.0, SECTORS)[space.argmax()]
    return np.array([np.clip(1.2 * seen[5:11].min() - 0.2, 0.0, 1.0), turn], np.float32)


def score(policy: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Returns of 40 episodes in offices that nobody trained on."""
    env, returns = explorer(), np.zeros(40)
    for k in range(len(returns)):
        (seen, _), over = env.reset(seed=1_000_000 + k), False
        while not over:
            seen, reward, terminated, truncated, _ = env.step(policy(seen))
            returns[k] += reward
            over = terminated or truncated
    env.close()
    return returns


def draw(monitors: list[Path], rivals: dict[str, float]) -> None:
    """The return of each training episode over the steps, and its mean over 20 episodes."""
    logs = np.concatenate([np.genfromtxt(path, delimiter=",", skip_header=2) for path in monitors])
    returns, lengths, _ = logs[logs[:, 2].argsort()].T
    axes = (figure := Figure((8, 4), dpi=120, layout="constrained")).add_subplot()
    axes.plot(lengths.cumsum(), returns, ".", color="0.7", label="a training episode")
    axes.plot(lengths.cumsum()[19:], np.convolve(returns, np.ones(20) / 20, "valid"), label="mean of the last 20")
    for style, (name, value) in zip((":", "--", "-."), rivals.items(), strict=True):
        axes.axhline(value, color="k", ls=style, lw=1, label=f"{name}, unseen offices: {value:.1f}")
    axes.set(xlabel="environment steps of 0.1 s", ylabel="return: newly seen m² - penalty")
    axes.legend(fontsize="small")
    figure.savefig(OUT / "curve.png")


if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    envs = SubprocVecEnv([lambda k=k: Monitor(explorer(), str(OUT / str(k))) for k in range(4)])
    model = PPO("MlpPolicy", envs, n_steps=512, batch_size=256, use_sde=True, sde_sample_freq=8, seed=0, device="cpu")
    model.learn(STEPS)
    envs.close()
    model.save(OUT / "policy")
    sampler = explorer().action_space
    scores = {"random": score(lambda seen: sampler.sample()), "by hand": score(by_hand)}
    scores["learnt"] = score(lambda seen: model.predict(seen, deterministic=True)[0])
    for name, returns in scores.items():
        print(f"{name}: {returns.mean():.1f} m^2 on average, {returns.min():.1f} to {returns.max():.1f}")
    draw(sorted(OUT.glob("*.monitor.csv")), {name: returns.mean() for name, returns in scores.items()})
