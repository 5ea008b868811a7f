"""Many kinematic robots as one gymnasium vector environment."""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Dict, Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from sim.batch.arguments import check_arguments, read_autoreset_mode, read_commands, read_reset_mask, read_seeds
from sim.batch.outcomes import TIME, batch_info, endings, reward_terms
from sim.batch.robots import BatchObservation, make_observation, make_robots
from sim.batch.slam_views import SlamViews
from sim.batch.step import begin_streams, step_robots
from sim.batch.worlds import timing_of, worlds_of
from slam.env.config import env_config
from slam.env.episode_scenarios import EpisodeScenarios
from slam.env.occupancy_grid import Extent
from slam.errors import InputError, RobotError
from slam.pose import FloatArray
from slam.run.gym_arrays import action_space
from slam.scenario.schema import Scenario
from slam.system import usable_cores

ObservationDict = dict[str, NDArray[Any]]


class BatchEnv(VectorEnv[ObservationDict, NDArray[np.float32], NDArray[Any]]):
    """``num_envs`` Pioneers P3-DX with lidars, moved by the kinematic model of ``physics.engine: plan``.

    Each robot is a ``P3DXEnv``: the same scenarios, actions, views, rewards, ends and ``info``, computed by one
    compiled function on all cores. The differences are:

    - There are no forces: whatever the robot touches stops it, and furniture with a mass stands like a wall.
    - Each episode takes place in one of ``worlds`` worlds, chosen by the robot's random numbers. The environment draws
      them when it is made, with consecutive seeds that begin with the scenario's own.
    - SLAM runs only with ``slam=True``, in one process for each thread, and takes a hundred times as long as the rest
      of a step. Without it ``map`` is built at the true pose, and ``slam_pose`` and the end ``lost`` are refused.
    - ``reset(seed=k)`` gives the robots the seeds k, k + 1, ..., which determine all their noise and worlds: the same
      bits for any number of threads. Its only option is ``reset_mask``.
    - ``info`` has no ``observation``. Its values are arrays with one element for each robot.

    | Argument | Default | Meaning |
    |---|---|---|
    | `num_envs` | `1` | number of robots |
    | `worlds` | `None` | number of worlds; by default 64, or 1 if the scenario has no random values |
    | `threads` | `None` | number of threads; by default one for each core |
    | `slam` | `False` | run SLAM, for `slam_pose`, `map` and the end `lost` |
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
        slam: bool = False,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        self.config = env_config(arguments)
        check_arguments(self.config, slam, render_mode, num_envs=num_envs, worlds=worlds, threads=threads)
        self.num_envs = num_envs
        self.metadata = {"autoreset_mode": read_autoreset_mode(autoreset_mode), "render_modes": []}
        self.render_mode = None
        drawn = EpisodeScenarios(scenario, settings, allow_modules, self.config)
        self.scenario = drawn.first
        scenarios = drawn.draw_pool(worlds)
        self._worlds, self._timing = worlds_of(scenarios, self.config), timing_of(drawn.first)
        self._views = _without_slam(self.config.observe, slam)
        with_grids = "map" in self._views or self.config.reward == "coverage"
        self._robots = make_robots(num_envs, self._worlds, with_grids)
        views = self.config.make_views(self.scenario, Extent.of(self.scenario))
        spaces: Space[Any] = Dict({name: view.space for name, view in views.items()})
        self.single_observation_space, self.single_action_space = spaces, action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._threads = min(threads or usable_cores(), num_envs)
        self._pool = ThreadPoolExecutor(self._threads) if self._threads > 1 else None
        self._slam = SlamViews(self.config, scenarios, self._timing, self._threads) if slam else None
        self._over = np.ones(num_envs, np.bool_)
        self._seen: BatchObservation | None = None

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObservationDict, dict[str, Any]]:
        """Begin new episodes, of all robots or of those in the option ``reset_mask``, and take their first scans."""
        mask = read_reset_mask(options, self.num_envs)
        self._seed(seed, mask)
        rows: Iterable[Any] = () if self._seen is None else self._seen
        self._seen = BatchObservation(*map(np.copy, rows)) if self._seen else self._make_observation()
        self._step(mask, np.zeros_like(mask), np.zeros((self.num_envs, 2)))
        self._over &= ~mask
        terms = reward_terms(self._seen, self.config, mask)
        return self._observation(), self._info(mask, terms, np.zeros(self.num_envs, np.int64))

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[ObservationDict, FloatArray, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Drive every robot at the speeds of its action until its next scan."""
        if self._seen is None:
            raise RobotError("the environment has no episodes yet: call reset() first")
        mode, everyone = self.metadata["autoreset_mode"], np.ones(self.num_envs, np.bool_)
        if mode == AutoresetMode.DISABLED and self._over.any():
            raise InputError(f"{self._over.sum()} episodes are over: call reset(options={{'reset_mask': ...}}) first")
        begins = self._over if mode == AutoresetMode.NEXT_STEP else np.zeros_like(self._over)
        tracks = self._worlds.models["track"][self._robots.world]
        commands = read_commands(actions, self.config, tracks)
        self._seen = self._make_observation()
        self._step(begins, ~begins, commands)
        terms = reward_terms(self._seen, self.config, begins)
        lost = self._slam.lost if self._slam else np.zeros_like(begins)
        ending = endings(self._seen, self.config, begins, lost)
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
        """Stop the threads and the processes."""
        if self._pool is not None:
            self._pool.shutdown()
        if self._slam is not None:
            self._slam.close()

    def _step(self, begins: NDArray[np.bool_], continues: NDArray[np.bool_], commands: FloatArray) -> None:
        """Let the robots of ``begins`` begin an episode, and those of ``continues`` drive on, on all threads."""
        assert self._seen is not None
        polar, cell = self.config.goal_as == "polar", self.config.cell
        arguments = begins, continues, commands, self._worlds, self._timing, polar, cell, self._robots, self._seen
        if self._pool is None:
            step_robots(0, self.num_envs, *arguments)
        else:
            bounds = np.linspace(0, self.num_envs, self._threads + 1).astype(int).tolist()
            parts = [self._pool.submit(step_robots, a, b, *arguments) for a, b in pairwise(bounds)]
            for part in parts:
                part.result()
        if self._slam is not None:
            self._slam.update(begins, continues, self._robots, self._seen)

    def _finals(self, terms: dict[str, FloatArray], ending: NDArray[np.int64]) -> dict[str, Any]:
        """Return the observations and infos that ended episodes, in the form of gymnasium's own vector environments."""
        observation = self._observation()
        observations = np.full(self.num_envs, None, object)
        for robot in np.flatnonzero(self._over):
            observations[robot] = {name: rows[robot].copy() for name, rows in observation.items()}
        return {
            "final_obs": observations, "_final_obs": self._over.copy(),
            "final_info": self._info(self._over, terms, ending), "_final_info": self._over.copy(),
        }  # fmt: skip

    def _info(self, of: NDArray[np.bool_], terms: dict[str, FloatArray], ending: NDArray[np.int64]) -> dict[str, Any]:
        assert self._seen is not None
        slam = self._slam.info if self._slam else {}
        return batch_info(of, self._robots, self._seen, self._timing, terms, ending, slam)

    def _observation(self) -> ObservationDict:
        assert self._seen is not None
        estimated = self._slam.views if self._slam else {}
        return {
            name: estimated[name] if name in estimated else getattr(self._seen, name) for name in self.config.observe
        }

    @property
    def bytes_a_robot(self) -> float:
        """Memory of a robot and of its views in one step, without that of the worlds, which all robots share."""
        arrays = [*self._robots, *(self._seen or self._make_observation())]
        return sum(rows.nbytes for rows in arrays) / self.num_envs

    def _make_observation(self) -> BatchObservation:
        return make_observation(self.num_envs, self._worlds, self._timing, self._views, self.config.map_cells)

    def _seed(self, seed: int | Sequence[int | None] | None, mask: NDArray[np.bool_]) -> None:
        """Start the random streams of these robots; a robot without a seed continues its stream."""
        seeds, given = read_seeds(seed, self.num_envs)
        if self._seen is None:
            seeds = np.where(given, seeds, self.np_random.integers(2**31, size=self.num_envs, dtype=np.uint64))
            given[:] = True
        begin_streams(self._robots.base, seeds, given & mask)


def _without_slam(views: tuple[str, ...], slam: bool) -> tuple[str, ...]:
    """Views that the compiled step makes; with SLAM, the inputs of SLAM replace the views that SLAM makes."""
    return (*(name for name in views if name not in ("slam_pose", "map")), "odometry", "ranges") if slam else views
