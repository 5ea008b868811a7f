"""A Pioneer P3-DX, simulated or real, as a gymnasium environment."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

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
from slam.run.gym_arrays import action_space
from slam.scenario.schema import Scenario

ObservationDict = dict[str, NDArray[Any]]


class P3DXEnv(gymnasium.Env[ObservationDict, NDArray[np.float32]]):
    """A Pioneer P3-DX with a planar lidar in the world of a scenario, simulated or real.

    ## Description
    A differential-drive robot drives through a PyBullet world. Its lidar is noisy, and its odometry has the errors of
    its wheels. A step is one revolution of the lidar, 0.1 s: the action is held for that time, and then the scan is
    observed. Physics runs at ``physics.rate``, 240 steps a second, which must be a multiple of
    ``robot.control_rate``, the 60 control steps a second in which the base follows its ramps.

    With `backend="hardware"` the same class drives the real robot, or emulated devices, at the ports that the
    scenario's section ``hardware`` names; see Real Robots.

    ## Action Space
    ``Box(-1, 1, (2,), float32)``, in SI units:

    | `action` | first | second |
    |---|---|---|
    | `"twist"` | v, forward, m/s | omega, counter-clockwise, rad/s |
    | `"wheels"` | left rim, m/s | right rim, m/s |

    v = (left + right) / 2 and omega = (right - left) / b, with the track b = ``robot.odometry.track``. Nothing is
    scaled. A number beyond 1 is obeyed up to the scenario's limits, and `info["applied"]` is the command after all
    limits. An action of another shape, or with a number that is not finite, is an `InputError`.

    ## Observation Space
    A ``Dict`` of the keys in `observe`; the arrays are new at every step:

    | Key | Shape | Type | Content |
    |---|---|---|---|
    | `scan` | (beams,) | float32 | ranges in the fan of `lidar.model`, m; `range_max`: no echo; 0: too close |
    | `odometry` | (5,) | float32 | x, y (m), theta (rad), v (m/s), omega (rad/s), by the wheels, from the start |
    | `slam_pose` | (3,) | float32 | x, y (m), theta (rad), map frame, as the scenario's SLAM estimates it |
    | `map` | (1, n, n) | uint8 | 0 unknown, 127 free, 255 wall: what SLAM has seen around its pose, heading up |
    | `goal` | (2,) | float32 | next way-point of the route from the robot: (m, rad), or (x, y) in m; 0 at the end |

    `goal`, rewards and ends use the true pose, or SLAM's where the truth is not known. SLAM runs only if one of these
    needs it, or `slam_pose`, `map` or the end `lost`.

    ## Rewards
    | `reward` | Formula |
    |---|---|
    | `"progress"` | L[t-1] - L[t], m: L is the length of the path straight through all remaining way-points |
    | `"coverage"` | a^2 (N[t] - N[t-1]), m^2: N is the number of cells seen so far, of side a = `cell` |
    | `"none"` | 0 |

    A cell counts as seen if an echo lies in it, or if its middle lies in the polygon that the sensor and the ends of
    the beams form. Cells more than 1 m outside of the world do not count. A beam without an echo ends at the sensor's
    reach if its neighbours have no echo either; a single one is left out, because single echoes are lost at walls too.
    The cells of the first scan earn nothing. Each step with a collision costs `collision_penalty`.

    ## Starting State
    The robot is at rest at the scenario's start pose, after the first scan. The seed in `reset(seed=k)` determines all
    noise, and the random values of the scenario; the same seed gives the same bits. `reset(options={...})` changes this
    one episode. Other keys, and a place inside a solid, are refused:

    | Option | Value |
    |---|---|
    | `start` | `[x, y]` or `[x, y, theta]`, map frame, m and rad: where the robot starts |
    | `goal` | `[x, y]`, map frame, m: the only way-point of the route |
    | `settings` | `"key=value"`, or a list of such strings, on top of the scenario's |

    ## Episode End
    An episode is terminated by the first of `end_on`:

    - `collision`: the robot touched anything but the floor and furniture that it can push, or a wheel is stalled;
    - `goal`: the last way-point is within the route's `arrival`;
    - `lost`: SLAM reports it, or its pose is farther than `lost_beyond` from the true one, where that is known.

    It is truncated at the last scan within `max_seconds` and the scenario's `duration`. At its end the robot stops.

    ## Real Robots
    With `backend="hardware"`, actions, spaces, rewards, ends and `info` are the same, and time is real. Rewards and
    ends use SLAM's pose, which begins at the scenario's start pose; `info["pose_from"]` is `"estimate"`, and
    `info["T_map_base"]`, the truth, is nan. A `collision` is reported by the bumpers or the stall flag.

    - Before the first motion of every episode the environment asks on the terminal whether the path is clear. A program
      without a terminal needs `yes=True`, which skips the question. With `dry_run=True` the robot never moves.
    - `reset` opens the devices again, and moves nothing. The first episode assumes that the robot stands at the
      scenario's start pose. A later one begins where the robot came to rest, by SLAM, with odometry at 0 and an empty
      map. To begin at the start pose again, carry the robot there, and call `close()` and `reset()`. The option `start`
      is refused. A random scenario is always drawn with its own seed; `seed` is only that of SLAM's random numbers.
    - The robot stops if no action comes for ``hardware.command_timeout``, 0.5 s. A policy that is slower than the lidar
      gets the newest scan, and misses the others. The robot also stops if scans or odometry stop coming: the step then
      waits for ``hardware.patience``, and raises `RobotTimeout`. Before `step` raises any error, the robot is stopped;
      only after a wrong action can the episode go on. `close()`, the end of the program and the garbage collection of
      the environment stop it too.

    `backend="module:Class"` drives your own robot. If it has a method `restart(seed)`, every reset calls it, to put the
    robot back to its start. Otherwise it is treated as a real robot, but a true pose that it reports is used.

    ## Arguments
    | Argument | Default | Meaning |
    |---|---|---|
    | `scenario` | `"corridor"` | name of a shipped scenario, path to a YAML file, or a `Scenario` |
    | `settings` | `()` | `"key=value"` strings on top of a named scenario |
    | `allow_modules` | `()` | modules whose code the scenario's file may run; none: see docs/extend.md |
    | `render_mode` | `None` | `"rgb_array"`: the view from above; `"human"`: the window of the rerun viewer |
    | `backend` | `"sim"` | or `"hardware"`, or `"module:Class"` |
    | `yes` | `False` | the real robot moves without asking |
    | `dry_run` | `False` | the real robot never moves |
    | `action` | `"twist"` | or `"wheels"` |
    | `observe` | `("scan", "odometry")` | keys of the observation |
    | `reward` | `"progress"` | or `"coverage"`, `"none"` |
    | `collision_penalty` | `0.0` | per step with a collision |
    | `end_on` | `("collision", "goal")` | what terminates; `"lost"` may be added |
    | `max_seconds` | `None` | time after which an episode is truncated, s |
    | `lost_beyond` | `1.0` | distance from the true pose at which SLAM counts as lost, m |
    | `goal_as` | `"polar"` | or `"xy"`: x ahead, y to the left |
    | `map_cells` | `64` | n, cells along a side of `map` |
    | `cell` | `0.1` | side of a cell of `map` and of the seen area, m |

    ## Info
    | Key | Type | Content |
    |---|---|---|
    | `T_map_base` | (3,) | the true pose: x, y (m), theta (rad); nan where the robot does not know it |
    | `pose` | (3,) | the pose that `goal`, rewards and ends use: x, y (m), theta (rad) |
    | `pose_from` | str | where `pose` comes from: `truth` or `estimate` |
    | `collided` | bool | the robot touched something that it cannot push since the last scan |
    | `stalled` | bool | the motors have stalled: the robot is blocked |
    | `applied` | (2,) | v (m/s), omega (rad/s): the command within the limits |
    | `stamp` | float | of the scan, s |
    | `seconds` | float | time in this episode |
    | `route_left` | float | L of `progress`, m |
    | `reward` | dict | the terms of the reward: one with the name of the argument `reward`, and `collision` |
    | `ending` | str | `collision`, `goal`, `lost` or `time`; empty until then |
    | `slam_pose` | (3,) | x, y (m), theta (rad), map frame |
    | `slam_covariance` | (3, 3) | of `slam_pose`, map frame; nan in paper mode, which has none |
    | `slam_lost` | bool | SLAM reports that it is lost |
    | `slam_odometry_only` | bool | `slam_pose` is moved by odometry alone: the scan was not matched, or not used |
    | `slam_error` | float | distance between the true and the estimated position, m; nan without the truth |
    | `observation` | `Observation` | all that the robot reported: scan, odometry, truth, bumpers, sonar, people |

    The keys that begin with `slam_` exist if `slam_pose`, `map` or `lost` is used. Times in the simulator are
    simulated, so the same seed gives the same `info`. ``env.unwrapped.episode.state.estimate.total_time`` is the
    real time that SLAM took, seconds.

    ## Copies
    Before the first reset, and after close, an environment can be copied and pickled: the copy is a new one with the
    same arguments. In between it refuses; `gymnasium.make(env.spec)` makes another.

    ## Version History
    v0: the first. Since 0.2.0 the area between two beams counts as seen, in `map` and in coverage.
    """

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
        """Put the robot at its start, at rest, and take the first scan; the seed decides all random numbers."""
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
        """Drive at the speeds of the action until the next scan.

        InputError for an invalid action, and for one that could move a real robot after the end of its episode.
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
        """Draw the view from above, (height, width, 3), for ``rgb_array``; None otherwise.

        Walls are grey, the scan yellow, SLAM's lines blue and its pose orange, the true pose dark, the next way-point
        violet, people sky blue. Unknown items are left out.
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
        """Bring the robot to rest, and return its pose in the last episode; None if there was no episode."""
        if self._episode is None:
            return None
        self._session.come_to_rest(self._episode.update)
        return self._episode.state.T_map_base
