"""Speed and memory of the learning environments: physics, the kinematic model alone, and batches of it."""

from collections.abc import Callable, Sequence
from time import perf_counter, process_time, thread_time
from typing import Any, Final

import numpy as np
from gymnasium.vector import VectorEnv

from sim.batch.env import BatchEnv
from sim.bench.planar_peer import PlanarPeer
from sim.bench.speed import corridor
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.env.p3dx_env import P3DXEnv
from slam.system import usable_cores

ROUNDS: Final = 7
"""Rounds of a measurement, of which the fastest counts."""
SECONDS: Final = 0.5
"""Length of a round, seconds."""
THREAD_ROUNDS: Final = 5
WITH_SLAM: Final = (1, 16)
SLAM_STEPS: Final = 50
ACTION: Final = np.array([0.3, 0.1], np.float32)
SIZES: Final = (1, 64, 1024, 4096)
VIEWS: Final = (("scan", "odometry"), ("scan", "odometry", "goal"), ("scan", "odometry", "goal", "map"))
_NO_TASK: Final[dict[str, Any]] = {"reward": "none", "end_on": ()}


def env_tables(
    console: Terminal,
    sizes: Sequence[int] = SIZES,
    seconds: float = SECONDS,
    peer: bool = False,
    with_slam: Sequence[int] = WITH_SLAM,
) -> list[ResultTable]:
    """Measure the steps per second of every environment on one core, on several threads and with SLAM, and the memory.

    With ``peer`` ir-sim is measured too; ``with_slam`` are numbers of robots.
    """
    parts: list[Callable[[], ResultTable]] = [
        lambda: _environments(sizes, seconds, peer),
        lambda: _views(sizes[-1], seconds),
        lambda: _threads(sizes[-1], seconds),
        lambda: _slam(with_slam),
    ]
    with console.progress(still=True) as bar:
        return [part() for part in bar.track(parts, description="environments")]


def _environments(sizes: Sequence[int], seconds: float, peer: bool) -> ResultTable:
    rows = []
    if peer:
        rows.append(("ir-sim, one robot", "1", *_speed(PlanarPeer(corridor("exact")), 1, seconds)))
    for name, engine in (("PyBullet", "bullet"), ("plan", "plan")):
        rows.append((f"{name}, one robot", "1", *_speed(_single(engine), 1, seconds)))
    rows += [("batch", str(size), *_speed(_batch(size), size, seconds)) for size in sizes]
    notes = (
        f"{_walls()} walls; views: scan and odometry; 682 beams with noise, fired one after the other. CPU time of one "
        f"thread, the least of {ROUNDS} rounds of {seconds:g} s."
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
    """Measure several numbers of threads in turn, so that other load on the machine affects all of them alike."""
    counts = [n for n in (1, 2, 4, 8) if n <= min(usable_cores(), size)]
    rounds = [[_thread_times(_batch(size, threads=n), size, seconds) for n in counts] for _ in range(THREAD_ROUNDS)]
    best = [min(of_count) for of_count in zip(*rounds, strict=True)]
    rows = [
        (str(n), f"{size / wall:.0f}", f"{best[0][0] / wall:.2f}", f"{1e6 * cpu / size:.1f}", f"{100 * main / cpu:.1f}")
        for n, (wall, cpu, main) in zip(counts, best, strict=True)
    ]
    notes = (
        f"Wall time, the best of {THREAD_ROUNDS} rounds; each thread needs an idle core. Last column: share of the CPU "
        "time that cannot be divided among threads."
    )
    columns = ("threads", "steps/s", "speed-up", "CPU us\na step", "in the main\nthread, %")
    return ResultTable(f"Threads of a batch of {size}", columns, rows, notes)


def _slam(sizes: Sequence[int]) -> ResultTable:
    rows = []
    for size in sizes:
        envs = _batch(size, threads=None, slam=True, observe=("scan", "odometry", "slam_pose", "map"))
        actions = np.tile(ACTION, (size, 1))
        envs.reset(seed=0)
        began = perf_counter()
        for _ in range(SLAM_STEPS):
            envs.step(actions)
        taken = (perf_counter() - began) / SLAM_STEPS / size
        envs.close()
        rows.append((str(size), f"{1.0 / taken:.0f}", f"{1e3 * taken:.2f}"))
    notes = f"Wall time on {usable_cores()} cores, each with a process of its own."
    return ResultTable("A batch with SLAM", ("robots", "steps/s", "ms\na step"), rows, notes)


def _thread_times(envs: Any, size: int, seconds: float) -> tuple[float, float, float]:
    """Return the wall time, the CPU time of all threads and of this thread for one step of all robots.

    It closes the environment.
    """
    actions = np.tile(ACTION, (size, 1))
    envs.reset(seed=0)
    envs.step(actions)
    steps, began, busy, own = 0, perf_counter(), process_time(), thread_time()
    while steps == 0 or perf_counter() - began < seconds:
        envs.step(actions)
        steps += 1
    times = perf_counter() - began, process_time() - busy, thread_time() - own
    envs.close()
    return times[0] / steps, times[1] / steps, times[2] / steps


def _speed(envs: Any, size: int, seconds: float) -> tuple[str, str]:
    taken = _seconds_a_step(envs, size, seconds, process_time)
    return f"{size / taken:.0f}", f"{1e6 * taken / size:.1f}"


def _seconds_a_step(envs: Any, size: int, seconds: float, clock: Callable[[], float]) -> float:
    """Return the seconds of this clock for one step of all robots; closes the environment."""
    actions = np.tile(ACTION, (size, 1)) if isinstance(envs, VectorEnv) else ACTION
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
    return P3DXEnv(scenario.model_copy(update={"physics": physics}), **_NO_TASK)


def _batch(size: int, threads: int | None = 1, **arguments: Any) -> BatchEnv:
    scenario = corridor("exact")
    route = scenario.route.model_copy(update={"waypoints": ((30.0, 0.0),)})
    given = _NO_TASK | arguments
    return BatchEnv(size, scenario.model_copy(update={"route": route}), threads=threads, **given)


def _walls() -> int:
    scenario = corridor("exact")
    return sum(map(len, scenario.world.outlines(scenario.lidar.height)))
