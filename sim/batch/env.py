"""Many kinematic robots as one gymnasium vector environment."""

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from gymnasium.spaces import Dict, Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from sim.batch.robots import Seen, make_robots, make_seen
from sim.batch.step import begin_streams, step_robots
from sim.batch.worlds import grid_shape, timing_of, worlds_of
from slam.env.config import env_config
from slam.env.episode_scenarios import EpisodeScenarios
from slam.env.occupancy_grid import Extent
from slam.errors import InputError, RobotError
from slam.pose import FloatArray
from slam.run.gym_arrays import action_space
from slam.scenario.schema import Scenario

ObservationDict = dict[str, NDArray[Any]]
ENDINGS: Final = ("", "collision", "goal", "time")
TIME: Final = 3


class BatchEnv(VectorEnv[ObservationDict, NDArray[np.float32], NDArray[Any]]):
    """``num_envs`` Pioneers P3-DX with lidars, moved by the kinematic model of ``physics.engine: plan``.

    It is ``P3DXEnv`` many times over: the same scenarios, actions, views, rewards, ends and ``info``, made by one
    compiled function on all cores. It differs in this:

    - Nothing has forces: what the robot meets stops it, and furniture with a mass stands like a wall.
    - Each episode takes place in one of ``worlds`` worlds, which are drawn when the environment is made, of the seeds
      from the scenario's own on; the robot's random numbers choose.
    - ``map`` is put together at the true pose, as SLAM without error would. ``slam_pose`` and the end ``lost`` need
      SLAM and are refused.
    - ``reset(seed=k)`` gives the robots the seeds k, k + 1, ... and so decides all their noise and worlds: the same
      bits whatever the number of threads. The option ``reset_mask`` is the only one.
    - ``info`` has no ``observation``; what it has are arrays of all robots.

    | Argument | Default | Meaning |
    |---|---|---|
    | `num_envs` | `1` | number of robots |
    | `worlds` | `None` | number of worlds; 1 where the scenario leaves nothing to chance, else 64 |
    | `threads` | `None` | number of threads; as many as there are cores |
    | `autoreset_mode` | `NEXT_STEP` | one of ``gymnasium.vector.AutoresetMode``, or its name |

    The others are those of ``P3DXEnv``: `scenario`, `settings`, `allow_modules`, `action`, `observe`, `reward`,
    `collision_penalty`, `end_on`, `max_seconds`, `goal_as`, `map_cells`, `cell`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        scenario: str | Path | Scenario = "corridor",
        settings: str | Sequence[str] = (),
        allow_modules: str | Sequence[str] = (),
        worlds: int | None = None,
        threads: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: None = None,
        **arguments: Any,
    ) -> None:
        self.config = env_config(arguments)
        if "slam_pose" in self.config.observe or "lost" in self.config.end_on:
            raise InputError(
                "a batch runs no SLAM: leave slam_pose out of observe and lost out of end_on, or choose "
                "vectorization_mode='async'"
            )
        self.num_envs = num_envs
        self.metadata = {"autoreset_mode": AutoresetMode(autoreset_mode), "render_modes": []}
        self.render_mode = render_mode
        drawn = EpisodeScenarios(scenario, settings, allow_modules, self.config)
        self.scenario = drawn.first
        scenarios = drawn.draw_pool(worlds)
        self._worlds, self._timing = worlds_of(scenarios, self.config), timing_of(drawn.first)
        needs_grid = "map" in self.config.observe or self.config.reward == "coverage"
        grid = grid_shape(scenarios, self.config.cell) if needs_grid else (0, 0)
        self._robots = make_robots(num_envs, self._worlds, grid)
        views = self.config.make_views(self.scenario, Extent.of(self.scenario))
        spaces: Space[Any] = Dict({name: view.space for name, view in views.items()})
        self.single_observation_space, self.single_action_space = spaces, action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._threads = min(threads or len(os.sched_getaffinity(0)), num_envs)
        self._pool = ThreadPoolExecutor(self._threads) if self._threads > 1 else None
        self._over = np.ones(num_envs, np.bool_)
        self._seen: Seen | None = None

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObservationDict, dict[str, Any]]:
        """Begin new episodes, of all robots or of those of the option ``reset_mask``, and take their first scans."""
        mask = _reset_mask(options, self.num_envs)
        self._seed(seed, mask)
        rows: Iterable[Any] = () if self._seen is None else self._seen
        self._seen = Seen(*map(np.copy, rows)) if self._seen else self._make_seen()
        self._step(mask, np.zeros_like(mask), np.zeros((self.num_envs, 2)))
        self._over &= ~mask
        return self._observation(), self._info(mask, self._terms(mask), np.zeros(self.num_envs, np.int64))

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[ObservationDict, FloatArray, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Drive every robot at the speeds of its action until its next scan has come."""
        if self._seen is None:
            raise RobotError("the environment has no episodes yet: call reset() first")
        mode, everyone = self.metadata["autoreset_mode"], np.ones(self.num_envs, np.bool_)
        if mode == AutoresetMode.DISABLED and self._over.any():
            raise InputError(f"{self._over.sum()} episodes are over: call reset(options={{'reset_mask': ...}}) first")
        begins = self._over if mode == AutoresetMode.NEXT_STEP else np.zeros_like(self._over)
        commands = self._commands(actions)
        self._seen = self._make_seen()
        self._step(begins, ~begins, commands)
        terms, ending = self._terms(begins), self._endings(begins)
        terminated, truncated = (ending > 0) & (ending < TIME), self._seen.late & ~begins
        rewards = np.sum(list(terms.values()), axis=0)
        ending = np.where((ending == 0) & truncated, TIME, ending)
        self._over = terminated | truncated
        if mode != AutoresetMode.SAME_STEP or not self._over.any():
            return self._observation(), rewards, terminated, truncated, self._info(everyone, terms, ending)
        final = self._finals(terms, ending)
        self._step(self._over, np.zeros_like(everyone), commands)
        begun = np.where(self._over, 0, ending)
        terms = {name: np.where(self._over, 0.0, term) for name, term in terms.items()}
        self._over = np.zeros_like(everyone)
        return self._observation(), rewards, terminated, truncated, self._info(everyone, terms, begun) | final

    def close_extras(self, **kwargs: Any) -> None:
        """Let the threads go."""
        if self._pool is not None:
            self._pool.shutdown()

    def _step(self, begins: NDArray[np.bool_], goes_on: NDArray[np.bool_], commands: FloatArray) -> None:
        """Let these robots begin an episode and those go on, in as many threads as there are."""
        assert self._seen is not None
        polar, cell = self.config.goal_as == "polar", self.config.cell
        arguments = begins, goes_on, commands, self._worlds, self._timing, polar, cell, self._robots, self._seen
        if self._pool is None:
            step_robots(0, self.num_envs, *arguments)
            return
        bounds = np.linspace(0, self.num_envs, self._threads + 1).astype(int).tolist()
        parts = [self._pool.submit(step_robots, a, b, *arguments) for a, b in pairwise(bounds)]
        for part in parts:
            part.result()

    def _commands(self, actions: NDArray[Any]) -> FloatArray:
        """Read actions (N, 2) as v and omega; InputError for anything but finite numbers."""
        numbers = np.asarray(actions, np.float64)
        if numbers.shape != (self.num_envs, 2):
            raise InputError(f"actions have the shape ({self.num_envs}, 2); these have {numbers.shape}")
        if not np.isfinite(numbers).all():
            robot = int(np.flatnonzero(~np.isfinite(numbers).all(axis=1))[0])
            raise InputError(f"actions are finite numbers; that of robot {robot} is {numbers[robot].tolist()}")
        if self.config.action == "twist":
            return numbers
        left, right = numbers.T
        return np.column_stack(
            [(left + right) / 2.0, (right - left) / self._worlds.models["track"][self._robots.world]]
        )

    def _terms(self, begins: NDArray[np.bool_]) -> dict[str, FloatArray]:
        """Terms whose sum is the reward, (N,) each; 0 for the first scan of an episode."""
        assert self._seen is not None
        metres, cells = self._seen.gained.T
        gained = {"progress": metres, "coverage": self.config.cell**2 * cells, "none": 0.0 * metres}
        hit = (self._seen.collided | self._seen.stalled) & ~begins
        return {self.config.reward: gained[self.config.reward], "collision": -self.config.collision_penalty * hit}

    def _endings(self, begins: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Number in ENDINGS of the first end of ``end_on`` that has come, (N,)."""
        assert self._seen is not None
        come = {"collision": self._seen.collided | self._seen.stalled, "goal": self._seen.arrived}
        ending = np.zeros(self.num_envs, np.int64)
        for name in reversed(self.config.end_on):
            ending[come[name] & ~begins] = ENDINGS.index(name)
        return ending

    def _finals(self, terms: dict[str, FloatArray], ending: NDArray[np.int64]) -> dict[str, Any]:
        """Observations and infos with which episodes ended, as gymnasium's own vector environments give them."""
        observation = self._observation()
        observations = np.full(self.num_envs, None, object)
        for robot in np.flatnonzero(self._over):
            observations[robot] = {name: rows[robot].copy() for name, rows in observation.items()}
        return {
            "final_obs": observations, "_final_obs": self._over.copy(),
            "final_info": self._info(self._over, terms, ending), "_final_info": self._over.copy(),
        }  # fmt: skip

    def _info(self, of: NDArray[np.bool_], terms: dict[str, FloatArray], ending: NDArray[np.int64]) -> dict[str, Any]:
        """Make the ``info`` of these robots: copies of arrays of all, and beside each, under ``_key``, whose it is."""
        assert self._seen is not None
        seen, turns, timing = self._seen, self._robots.turns, self._timing
        info: dict[str, Any] = {
            "T_map_base": seen.pose.copy(),
            "pose": seen.pose.copy(),
            "pose_from": np.full(self.num_envs, "truth"),
            "collided": seen.collided.copy(),
            "stalled": seen.stalled.copy(),
            "applied": seen.applied.copy(),
            "stamp": (turns - 1) * timing.scan_time + timing.controls_before * timing.period,
            "seconds": turns * timing.scan_time,
            "route_left": self._robots.left.copy(),
            "reward": {name: term.copy() for name, term in terms.items()} | {f"_{name}": of.copy() for name in terms},
            "ending": np.array(ENDINGS)[ending],
        }
        return info | {f"_{key}": of.copy() for key in info}

    def _observation(self) -> ObservationDict:
        assert self._seen is not None
        return {name: getattr(self._seen, name) for name in self.config.observe}

    @property
    def bytes_a_robot(self) -> float:
        """Memory of a robot and of what it sees in one step; that of the worlds, which they share, comes on top."""
        arrays = [*self._robots, *(self._seen or self._make_seen())]
        return sum(rows.nbytes for rows in arrays) / self.num_envs

    def _make_seen(self) -> Seen:
        beams = self.scenario.lidar.description.lidar.beams
        return make_seen(self.num_envs, beams, self.config.observe, self.config.map_cells)

    def _seed(self, seed: int | Sequence[int | None] | None, mask: NDArray[np.bool_]) -> None:
        """Begin the streams of random numbers of these robots; those without a seed go on with theirs."""
        if seed is None and self._seen is None:
            seed = self.np_random.integers(2**31, size=self.num_envs).tolist()
        if seed is None:
            return
        seeds = [seed + k for k in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise InputError(f"seed: give one for each of the {self.num_envs} robots; these are {len(seeds)}")
        given = np.array([one is not None for one in seeds]) & mask
        begin_streams(self._robots.base, np.array([one or 0 for one in seeds], np.uint64), given)


def _reset_mask(options: dict[str, Any] | None, count: int) -> NDArray[np.bool_]:
    """Read the robots to reset from the options; InputError names what is wrong with them."""
    given = options or {}
    for key in given:
        if key != "reset_mask":
            raise InputError(f"options: no option {key!r}; a batch has reset_mask alone")
    mask = np.asarray(given.get("reset_mask", np.ones(count, np.bool_)))
    if mask.shape != (count,) or mask.dtype != np.bool_:
        raise InputError(f"options: reset_mask: give {count} booleans; these are {mask.shape} of {mask.dtype}")
    return mask
