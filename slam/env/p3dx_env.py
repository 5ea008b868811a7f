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

    ## Description A differential-drive robot drives through a PyBullet world, with a noisy lidar and odometry from
    wheels with errors. One step is one turn of the lidar, 0.1 s: the action is held for that time, and at the end the
    scan is observed. Meanwhile physics advances at ``physics.rate``, 240 steps a second, and the base follows its ramps
    at ``robot.control_rate``, 60 times a second. A scenario in which one does not divide the other is refused.

    With `backend="hardware"` the same class drives the real robot, or emulated devices, at the ports that the
    scenario's section ``hardware`` names; see Real Robots.

    ## Action Space
    ``Box(-1, 1, (2,), float32)``, in SI units:

    | `action` | first | second |
    |---|---|---|
    | `"twist"` | v, forward, m/s | omega, counter-clockwise, rad/s |
    | `"wheels"` | left rim, m/s | right rim, m/s |

    v = (left + right) / 2 and omega = (right - left) / b, with the track b = ``robot.odometry.track``. Nothing is
    scaled; a number beyond 1 is obeyed up to the scenario's limits, and `info["applied"]` is what the base was told in
    the end. Another shape, and numbers that are not finite, are an `InputError`.

    ## Observation Space
    A ``Dict`` of the keys in `observe`, fresh arrays at every step:

    | Key | Shape | Type | Content |
    |---|---|---|---|
    | `scan` | (beams,) | float32 | ranges in the fan of `lidar.model`, m; `range_max`: no echo; 0: too close |
    | `odometry` | (5,) | float32 | x, y (m), theta (rad), v (m/s), omega (rad/s), as the wheels say, from the start |
    | `slam_pose` | (3,) | float32 | x, y (m), theta (rad), map frame, as the scenario's SLAM estimates it |
    | `map` | (1, n, n) | uint8 | 0 unknown, 127 free, 255 wall: what SLAM has seen around its pose, heading up |
    | `goal` | (2,) | float32 | next way-point of the route from the robot: (m, rad), or (x, y) in m; 0 at the end |

    The pose in `goal`, rewards and ends is the true one; where the robot does not know it, that of SLAM. SLAM runs only
    where this, `slam_pose`, `map` or the end `lost` need it.

    ## Rewards
    | `reward` | Formula |
    |---|---|
    | `"progress"` | L[t-1] - L[t], m: L is the straight way from the robot's position through all way-points left |
    | `"coverage"` | a^2 (N[t] - N[t-1]), m^2: N cells of side a = `cell` were spanned by beams, or met by one |
    | `"none"` | 0 |

    Coverage casts the beams from the robot's pose: a cell counts whose middle lies in the polygon from the sensor along
    the ends of the beams and back, or that an echo lies in, up to 1 m around the world. A beam without an echo counts
    as far as the sensor reaches, but only among neighbours without one, for lone ones are lost in front of walls too.
    The first scan earns no reward. In every step with a collision `collision_penalty` is taken off.

    ## Starting State
    At rest at the scenario's start pose, after the first scan. `reset(seed=k)` decides all noise, and draws the world
    too where the scenario leaves something to chance; the same seed gives the same bits. `reset(options={...})` changes
    this one episode; any other key, and a place inside a solid, are refused:

    | Option | Value |
    |---|---|
    | `start` | `[x, y]` or `[x, y, theta]`, map frame, m and rad: where the robot starts |
    | `goal` | `[x, y]`, map frame, m: the only way-point of the route |
    | `settings` | `"key=value"`, or a list of such strings, on top of the scenario's |

    ## Episode End
    Terminated by the first of `end_on` that comes:

    - `collision`: the robot touched anything but the floor and furniture that it can push, or a wheel is stalled;
    - `goal`: the last way-point is within the route's `arrival`;
    - `lost`: SLAM says so itself, or its pose is farther than `lost_beyond` from the true one, where that is known.

    Truncated with the last scan within `max_seconds` and the scenario's `duration`. When an episode ends, the robot is
    told to stand.

    ## Real Robots
    With `backend="hardware"`, actions, spaces, rewards, ends and `info` are the same; the time is real. Rewards and
    ends come from SLAM, which starts at the scenario's start pose; `info["pose_from"]` says `"estimate"`, and
    `info["T_map_base"]`, the truth, is nan. A `collision` is what the bumpers and the stall flag tell.

    - Before the first motion of every episode it asks on the terminal whether the path is clear. `yes=True` leaves the
      question out, which a program without a terminal must; with `dry_run=True` the robot never moves.
    - `reset` opens the devices anew and moves nothing. The first episode takes the place where the robot stands for
      the scenario's start pose. A later one begins where the last one left the robot, as SLAM says after it has braked,
      with odometry at 0 and an empty map. After `close()`, it is the scenario's start pose again: do so when the robot
      was carried there. The option `start` is refused. A random scenario is always that of its own seed; `seed` decides
      what is random in SLAM only.
    - It stops when no action comes for ``hardware.command_timeout``, 0.5 s: a policy that is slower drives by fits and
      starts. One that is slower than the lidar gets the newest scan, and the others are skipped. It stops when scans or
      odometry stay away; a step then waits, standing, for ``hardware.patience``, and raises `RobotTimeout` after that.
      Whatever `step` raises, the robot is stopped before; only after a wrong action the episode can go on. `close()`,
      the end of the program and the loss of the environment stop it too.

    `backend="module:Class"` drives a robot of one's own. One that has a method `restart(seed)` is set back to its start
    at every reset; one without is treated as a real robot, except that its pose is the truth where it tells one.

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
    | `lost_beyond` | `1.0` | m |
    | `goal_as` | `"polar"` | or `"xy"`: x ahead, y to the left |
    | `map_cells` | `64` | n, cells along a side of `map` |
    | `cell` | `0.1` | side of a cell of `map` and of the seen area, m |

    ## Info
    | Key | Type | Content |
    |---|---|---|
    | `T_map_base` | (3,) | the true pose: x, y (m), theta (rad); nan where the robot does not know it |
    | `pose` | (3,) | the pose that `goal`, rewards and ends go by: x, y (m), theta (rad) |
    | `pose_from` | str | where `pose` comes from: `truth` or `estimate` |
    | `collided` | bool | the robot touched something that it cannot push since the last scan |
    | `stalled` | bool | a wheel cannot turn as it should: the robot is blocked |
    | `applied` | (2,) | v (m/s), omega (rad/s): the command within the limits |
    | `stamp` | float | of the scan, s |
    | `seconds` | float | time in this episode |
    | `route_left` | float | L of `progress`, m |
    | `reward` | dict | the parts whose sum is the reward: under the name of `reward`, and `collision` |
    | `ending` | str | `collision`, `goal`, `lost` or `time`; empty until then |
    | `slam_pose` | (3,) | x, y (m), theta (rad), map frame |
    | `slam_covariance` | (3, 3) | of `slam_pose`, map frame; nan in paper mode, which has none |
    | `slam_lost` | bool | SLAM says that it is lost |
    | `slam_odometry_only` | bool | `slam_pose` is odometry since a scan before: this one said nothing, or is not used |
    | `slam_error` | float | from the true position to the estimated one, m; nan without the truth |
    | `observation` | `Observation` | what the robot said, whole: scan, odometry, truth, bumpers, sonar, people |

    The keys that begin with `slam_` are there where `slam_pose`, `map` or `lost` was asked for. In the simulator times
    are simulated ones, so the same seed gives the same `info`. How long SLAM took on the wall's clock is
    ``env.unwrapped.episode.state.estimate.total_time``, seconds.

    ## Copies
    An environment that does not run, before the first reset or after close, can be copied and pickled: the copy is a
    new one with the same arguments. One that runs refuses; `gymnasium.make(env.spec)` makes another.

    ## Version History
    v0: the first. After 0.1.0, `map` and coverage take what lies between two beams for seen too.
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
