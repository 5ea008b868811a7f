"""Speed of the simulator, and PyBullet's own share of it: its calls are recorded, and repeated alone.

They are repeated in the world in which the whole is timed: two equal worlds differ by up to 5 % in speed, because their
memory lies elsewhere.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from math import sin
from time import perf_counter, process_time
from typing import Any, Literal
from unittest.mock import patch

import gymnasium
import numpy as np

from sim.bullet import Bullet
from sim.ray_casters import ExactCaster
from sim.robot import SimRobot
from slam.env.p3dx_env import P3DXEnv
from slam.odometry import Twist2D
from slam.pose import FloatArray
from slam.scenario.schema import Scenario

SEED = 0
SCANS = 60
ROUNDS = 40
STEPS = 300
"""Steps of every environment, without the first ones, which are not counted."""
Tape = list[Callable[[], Any]]


@dataclass(frozen=True, slots=True)
class Speed:
    """CPU seconds per scan: of the ``engine`` calls alone, and of the ``whole`` of drive and observe."""

    engine: float
    whole: float

    @property
    def ours(self) -> float:
        """Share of the whole that is spent outside the engine."""
        return 1.0 - self.engine / self.whole


def corridor(caster: Literal["bullet", "exact"]) -> Scenario:
    """Make a corridor of 35 m by 4 m with 40 boxes, in which the speed is measured.

    682 beams, fired one after the other, with the noise of the paper; 10 scans and 240 physics steps per second.
    """
    rng = np.random.default_rng(SEED)
    boxes = [
        {
            "center": [2.0 + 0.78 * k, float(rng.choice([-1.0, 1.0]) * rng.uniform(1.2, 1.8))],
            "size": [*rng.uniform(0.3, 0.7, 2).tolist(), 0.6],
            "yaw": float(rng.uniform(-1.0, 1.0)),
        }
        for k in range(40)
    ]
    walls = [{"points": [[-1.5, -2.0], [33.5, -2.0], [33.5, 2.0], [-1.5, 2.0]], "closed": True}]
    return Scenario.model_validate(
        {"name": "bench", "world": {"walls": walls, "boxes": boxes}, "lidar": {"caster": caster}, "duration": 1e6}
    )


def one_scan(robot: SimRobot, k: int) -> None:
    """Drive one scan of a winding path along the corridor."""
    robot.drive(Twist2D(0.5, 0.3 * sin(0.2 * k)))
    robot.observe()


@contextmanager
def recording(tape: Tape) -> Iterator[None]:
    """Record the calls of PyBullet and of the compiled ray caster that the robots of this block make."""
    real_prepared, real_cast = Bullet.prepared, ExactCaster.cast

    def prepared(self: Bullet, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[[], Any]:
        checked = real_prepared(self, function, *args, **kwargs)

        def call() -> Any:
            tape.append(partial(function, *deepcopy(args), **deepcopy(kwargs), physicsClientId=self._client))
            return checked()

        return call

    def cast(self: ExactCaster, rays: FloatArray) -> FloatArray:
        tape.append(partial(real_cast, self, rays))
        return real_cast(self, rays)

    with patch.object(Bullet, "prepared", prepared), patch.object(ExactCaster, "cast", cast):
        yield


def speed_of(scenario: Scenario) -> Speed:
    """Return the fastest of ROUNDS times of every scan, and of its calls alone, measured in turn."""
    tape: Tape = []
    engine, whole = np.empty((2, ROUNDS, SCANS))
    with recording(tape), SimRobot(scenario, 0) as noted:
        parts = [_calls_of(tape, partial(noted.restart, 0))]
        parts += [_calls_of(tape, partial(one_scan, noted, k)) for k in range(SCANS)]
    with SimRobot(scenario, 0) as robot:  # reuses the physics server of ``noted``: the recorded calls name it
        for turn in range(ROUNDS):
            robot.restart(0)
            whole[turn] = [cpu_seconds(partial(one_scan, robot, k)) for k in range(SCANS)]
            engine[turn] = [cpu_seconds(partial(_play, part)) for part in parts][1:]
    return Speed(float(engine.min(axis=0).mean()), float(whole.min(axis=0).mean()))


def _calls_of(tape: Tape, function: Callable[[], object]) -> Tape:
    """Return the recorded calls of this robot."""
    tape.clear()
    function()
    return tape.copy()


def cpu_seconds(function: Callable[[], object]) -> float:
    """Return the CPU seconds of this process for one call."""
    began = process_time()
    function()
    return process_time() - began


def _play(tape: Tape) -> None:
    """Repeat the recorded calls, without hopslam."""
    for call in tape:
        call()


def reset_times(scenario: Scenario) -> tuple[float, float]:
    """Return the median CPU seconds of a restart in the same world, and of a new robot in a new world."""
    with SimRobot(scenario, 0) as robot:
        same = [cpu_seconds(partial(robot.restart, seed)) for seed in range(200)]

    def renew() -> None:
        SimRobot(scenario, 0).close()

    renew()
    return float(np.median(same)), float(np.median([cpu_seconds(renew) for _ in range(30)]))


def env_steps_per_second(scenario: Scenario, processes: int) -> float:
    """Return the steps per second of all environments together, in wall time."""
    envs = gymnasium.vector.AsyncVectorEnv([partial(P3DXEnv, scenario, reward="none")] * processes)
    try:
        envs.reset(seed=0)
        actions = np.tile(np.array([0.2, 0.1], np.float32), (processes, 1))
        for _ in range(20):
            envs.step(actions)
        began = perf_counter()
        for _ in range(STEPS):
            envs.step(actions)
        return processes * STEPS / (perf_counter() - began)
    finally:
        envs.close()
