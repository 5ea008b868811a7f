"""A Pioneer P3-DX, simulated or real, as a gymnasium environment."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Dict, Space
from numpy.typing import NDArray

from slam.env.config import env_config
from slam.env.episode import Episode
from slam.env.episode_scenarios import EpisodeScenarios, ResetOptions
from slam.env.occupancy_grid import Extent
from slam.env.rerun_window import RerunWindow
from slam.env.robot_session import RobotSession
from slam.env.top_view import TopView
from slam.errors import InputError, RobotError
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.robot import Robot
from slam.run.arrays import action_space
from slam.scenario.schema import Scenario

MANUAL: Final = Path(__file__).with_name("manual.md").read_text(encoding="utf-8")
"""The docstring of the environment, and its manual: spaces, rewards, ends, arguments, info."""
ObservationDict = dict[str, NDArray[Any]]


class P3DXEnv(gymnasium.Env[ObservationDict, NDArray[np.float32]]):
    __doc__ = MANUAL
    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 10}  # noqa: RUF012  # as in Env

    def __init__(
        self,
        scenario: str | Path | Scenario = "corridor",
        settings: str | Sequence[str] = (),
        render_mode: Literal["human", "rgb_array"] | None = None,
        backend: str = "sim",
        yes: bool = False,
        dry_run: bool = False,
        allow_modules: str | Sequence[str] = (),
        **arguments: Any,
    ) -> None:
        self._made_with = {"scenario": scenario, "settings": settings, "render_mode": render_mode} | arguments
        self._made_with |= {"backend": backend, "yes": yes, "dry_run": dry_run, "allow_modules": allow_modules}
        self.config = env_config(arguments)
        self._session = RobotSession(backend, yes=yes, dry_run=dry_run)
        self._scenarios = EpisodeScenarios(scenario, settings, allow_modules, self.config)
        self.scenario = self._scenarios.first
        self._extent = Extent.of(self.scenario)
        views = self.config.make_views(self.scenario, self._extent)
        spaces: Space[Any] = Dict({name: view.space for name, view in views.items()})
        self.observation_space = spaces
        self.action_space: Space[Any] = action_space()
        self.render_mode = render_mode
        self._top_view: TopView | None = None
        self._window = RerunWindow() if render_mode == "human" else None
        self._episode: Episode | None = None
        self._over = False

    @property
    def robot(self) -> Robot:
        """The robot; RobotError before the first reset and after close."""
        return self._session.robot

    @property
    def episode(self) -> Episode:
        """The episode that is running; RobotError before the first reset and after close."""
        if self._episode is None:
            raise RobotError("the environment has no episode yet: call reset() first")
        return self._episode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObservationDict, dict[str, Any]]:
        """Put the robot at its start, at rest, and take the first scan; the seed decides all that is random."""
        super().reset(seed=seed)
        seed = int(self.np_random.integers(2**31)) if seed is None else seed
        with self._session.stopping():
            self._episode = self._begin(seed, ResetOptions.of(options))
            self._over = False
        if self._window is not None:
            self._window.begin(self._episode)
        terms = dict.fromkeys((self.config.reward, "collision"), 0.0)
        return self._episode.views(), self._episode.info(Twist2D(), terms, "")

    def step(self, action: Any) -> tuple[ObservationDict, float, bool, bool, dict[str, Any]]:
        """Drive at the speeds of the action until the next scan has come.

        InputError for what is no such action, and for one that would move a robot after the end of its episode, if
        that may be a real one.
        """
        with self._session.stopping():
            twist = self.config.twist(action, self.scenario.robot.odometry.track)
            if self._over and twist != Twist2D() and not self._session.restartable:
                raise InputError("the episode is over: call reset() before the robot moves on")
            episode = self.episode
            applied, observation = self._session.step(twist, self.scenario.hardware.patience)
            episode.update(observation)
            end = self.config.ending(episode.state)
            self._over = bool(end) or episode.out_of_time
            if self._over:
                self._session.stand()
        if self._window is not None:
            self._window.show(episode, applied)
        terms = episode.reward_terms()
        info = episode.info(applied, terms, end or ("time" if episode.out_of_time else ""))
        return episode.views(), sum(terms.values()), bool(end), episode.out_of_time, info

    def render(self) -> NDArray[np.uint8] | None:
        """The view from above, (height, width, 3), with ``rgb_array``; None else.

        Walls are grey, the scan yellow, SLAM's lines blue and its pose orange, the true pose dark, the next way-point
        violet, people sky blue. What is not known is left out.
        """
        if self.render_mode != "rgb_array":
            return None
        if self._top_view is None:
            self._top_view = TopView(self.scenario, self._extent)
        slam = self.episode.slam
        lines = np.empty((0, 2, 2)) if slam is None else slam.lines.ends
        return self._top_view.frame(self.episode.state, lines)

    def close(self) -> None:
        """Stop the robot, and free its devices or the physics engine; closing twice is allowed."""
        self._session.close()
        self._episode = None
        if self._window is not None:
            self._window.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy as a new environment with the same arguments and random numbers; InputError while this one runs."""
        if self._session.running:
            raise InputError(
                "an environment that runs cannot be copied or pickled, nor can its robot; close() it first, or make "
                "another one: gymnasium.make(env.spec), reset(seed=...) with the same seed, and the same actions"
            )
        kept = ("spec", "action_space", "observation_space", "_np_random", "_np_random_seed")
        state = {name: self.__dict__[name] for name in kept if name in self.__dict__}
        return partial(type(self), **self._made_with), (), state

    def _begin(self, seed: int, options: ResetOptions) -> Episode:
        """Begin an episode: a simulated robot is put at its start, a real one stays where it is."""
        restartable = self._session.restartable
        if options.start is not None and not restartable:
            raise InputError(
                "options: start: this robot cannot be put anywhere, and the episode begins where it stands; leave it "
                "out, or carry the robot to the scenario's robot.start, call close(), and then reset()"
            )
        scenario = self._scenarios.draw(seed if restartable else None, options)
        left_at = None if restartable else self._left_at()
        if scenario is not self.scenario:
            self.scenario, self._extent = scenario, Extent.of(scenario)
            if self._top_view is not None:
                self._top_view.show(scenario, self._extent)
        first = self._session.start(scenario, seed)
        unmoved = left_at if first.T_map_base is None else None
        return Episode(self.config, scenario, self._extent, seed, unmoved or scenario.robot.start.pose, first)

    def _left_at(self) -> Pose2D | None:
        """Bring the robot to rest, and return its pose in the last episode; None where there was no episode."""
        if self._episode is None:
            return None
        self._session.come_to_rest(self._episode.update)
        return self._episode.state.T_map_base
