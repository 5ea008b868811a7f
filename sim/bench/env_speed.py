"""Speed and memory of the learning environments: physics, the kinematic model alone, and batches of it."""

from collections.abc import Callable, Sequence
from os import sched_getaffinity
from time import perf_counter, process_time
from typing import Any, Final

import gymnasium
import numpy as np

from sim.batch.env import BatchEnv
from sim.bench.speed import corridor
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.env.p3dx_env import P3DXEnv

ROUNDS: Final = 7
"""The least of so many times counts."""
SECONDS: Final = 0.5
"""Length of a round."""
SIZES: Final = (1, 64, 1024, 4096)
VIEWS: Final = (("scan", "odometry"), ("scan", "odometry", "goal"), ("scan", "odometry", "goal", "map"))
_FREE: Final[dict[str, Any]] = {"reward": "none", "end_on": ()}


def env_tables(console: Terminal, sizes: Sequence[int] = SIZES, seconds: float = SECONDS) -> list[ResultTable]:
    """Steps a second on one core of every path, on several threads, and the memory of a robot."""
    parts: list[Callable[[], ResultTable]] = [
        lambda: _paths(sizes, seconds),
        lambda: _views(sizes[-1], seconds),
        lambda: _threads(sizes[-1], seconds),
    ]
    with console.progress(still=True) as bar:
        return [part() for part in bar.track(parts, description="environments")]


def _paths(sizes: Sequence[int], seconds: float) -> ResultTable:
    rows = []
    for name, engine in (("PyBullet", "bullet"), ("plan", "plan")):
        rows.append((f"{name}, one robot", "1", *_speed(_single(engine), 1, seconds)))
    rows += [("batch", str(size), *_speed(_batch(size), size, seconds)) for size in sizes]
    notes = (
        f"{_walls()} walls, 682 noisy rolling beams, scan and odometry; CPU time of one thread, the least of {ROUNDS} "
        f"rounds of {seconds:g} s."
    )
    return ResultTable("Steps of environments", ("", "robots", "steps/s\na core", "us\na step"), rows, notes)


def _views(size: int, seconds: float) -> ResultTable:
    rows = []
    for views in VIEWS:
        envs = _batch(size, observe=views, reward="progress" if "goal" in views else "none")
        memory = f"{envs.bytes_a_robot / 1e3:.1f}"
        rows.append((", ".join(views), *_speed(envs, size, seconds), memory))
    columns = ("views", "steps/s\na core", "us\na step", "kB\na robot")
    return ResultTable(f"Views of a batch of {size}", columns, rows, "Memory: arrays of the robots and of one step.")


def _threads(size: int, seconds: float) -> ResultTable:
    rows: list[tuple[str, ...]] = []
    one = 0.0
    for threads in (n for n in (1, 2, 4, 8) if n <= min(len(sched_getaffinity(0)), size)):
        envs = _batch(size, threads=threads)
        taken = _seconds_a_step(envs, size, seconds, perf_counter)
        one = one or taken
        rows.append((str(threads), f"{size / taken:.0f}", f"{one / taken:.2f}"))
    notes = "By the clock on the wall; needs a core for each."
    return ResultTable(f"Threads of a batch of {size}", ("threads", "steps/s", "x one"), rows, notes)


def _speed(envs: Any, size: int, seconds: float) -> tuple[str, str]:
    taken = _seconds_a_step(envs, size, seconds, process_time)
    return f"{size / taken:.0f}", f"{1e6 * taken / size:.1f}"


def _seconds_a_step(envs: Any, size: int, seconds: float, clock: Callable[[], float]) -> float:
    """Seconds of this clock in one step of all robots; the environment is closed."""
    action = np.array([0.3, 0.1], np.float32)
    actions = action if isinstance(envs, gymnasium.Env) else np.tile(action, (size, 1))
    envs.reset(seed=0)
    envs.step(actions)
    best = np.inf
    for _ in range(ROUNDS):
        envs.reset(seed=0)
        steps, began = 0, clock()
        while steps == 0 or clock() - began < seconds:
            envs.step(actions)
            steps += 1
        best = min(best, (clock() - began) / steps)
    envs.close()
    return float(best)


def _single(engine: str) -> P3DXEnv:
    scenario = corridor("exact" if engine == "plan" else "bullet")
    physics = scenario.physics.model_copy(update={"engine": engine})
    return P3DXEnv(scenario.model_copy(update={"physics": physics}), **_FREE)


def _batch(size: int, threads: int = 1, **arguments: Any) -> BatchEnv:
    scenario = corridor("exact")
    route = scenario.route.model_copy(update={"waypoints": ((30.0, 0.0),)})
    given = _FREE | arguments
    return BatchEnv(size, scenario.model_copy(update={"route": route}), threads=threads, **given)


def _walls() -> int:
    scenario = corridor("exact")
    return sum(map(len, scenario.world.outlines(scenario.lidar.height)))
