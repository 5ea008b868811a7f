"""The simulated robot as a gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Dict, Space
from numpy.typing import NDArray

from sim.robot import SimRobot
from slam.errors import RobotError, ScenarioError
from slam.odometry import Twist2D
from slam.robot import Observation
from slam.run.env.actions import action_space, twist_action, wheels_action
from slam.run.env.config import env_config
from slam.run.env.ends import termination
from slam.run.env.episode import Episode
from slam.run.env.info import episode_info
from slam.run.env.seen_grid import Extent
from slam.run.env.top_view import TopView
from slam.run.env.views import make_views
from slam.run.scenario.file import load_template
from slam.run.scenario.schema import Scenario

ObservationDict = dict[str, NDArray[Any]]


class P3DXEnv(gymnasium.Env[ObservationDict, NDArray[np.float32]]):
    """A Pioneer P3-DX with a planar lidar in the world of a scenario.

    ## Description
    A differential-drive robot drives through a PyBullet world, sees it through a noisy lidar and reckons its way by
    wheels that err. One step is one turn of the lidar, 0.1 s: so long the action is held, and at the end the scan is
    observed. Meanwhile physics advances at ``physics.rate``, 240 steps a second, and the base follows its ramps at
    ``robot.control_rate``, 60 times a second. A scenario in which one does not divide the other is refused.

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
    | `scan` | (beams,) | float32 | ranges, m; `range_max` where no echo came back, 0 where something is too close |
    | `odometry` | (5,) | float32 | x, y (m), theta (rad), v (m/s), omega (rad/s), as the wheels say, from the start |
    | `slam_pose` | (3,) | float32 | x, y (m), theta (rad), map frame, as the scenario's SLAM estimates it |
    | `map` | (1, n, n) | uint8 | 0 unknown, 127 free, 255 wall: what SLAM has seen around its pose, heading up |
    | `goal` | (2,) | float32 | next way-point of the route from the true pose: (m, rad), or (x, y) in m; 0 at the end |

    SLAM runs only where `slam_pose`, `map` or the end `lost` need it.

    ## Rewards
    | `reward` | Formula |
    |---|---|
    | `"progress"` | L[t-1] - L[t], m: L is the straight way from the true position through all way-points left |
    | `"coverage"` | a^2 (N[t] - N[t-1]), m^2: N cells of side a = `cell` were seen, run through or met by a beam |
    | `"none"` | 0 |

    Coverage casts the beams from the true pose, and holds the area within 1 m around the world; a beam without an echo
    counts as far as the sensor reaches, but only among neighbours without one, for lone ones are lost in front of walls
    too. What the first scan sees is no merit. In every step with a collision `collision_penalty` is taken off.

    ## Starting State
    At rest at the scenario's start pose, after the first scan. `reset(seed=k)` decides all noise, and draws the world
    too where the scenario leaves something to chance; the same seed gives the same bits. `options` are not used.

    ## Episode End
    Terminated by the first of `end_on` that comes:

    - `collision`: the robot touched anything but the floor;
    - `goal`: the last way-point is within the route's `arrival`;
    - `lost`: SLAM says so itself, or its pose is farther than `lost_beyond` from the true one.

    Truncated with the last scan within `max_seconds` and the scenario's `duration`.

    ## Arguments
    | Argument | Default | Meaning |
    |---|---|---|
    | `scenario` | `"corridor"` | name of a shipped scenario, path to a YAML file, or a `Scenario` |
    | `settings` | `()` | `"key=value"` strings on top of a named scenario |
    | `render_mode` | `None` | `"rgb_array"`: the view from above, 10 frames a second |
    | `action` | `"twist"` | or `"wheels"` |
    | `observe` | `("scan", "odometry")` | keys of the observation |
    | `reward` | `"progress"` | or `"coverage"`, `"none"` |
    | `collision_penalty` | `0.0` | per step with a collision |
    | `end_on` | `("collision", "goal")` | what terminates; `"lost"` may be added |
    | `max_seconds` | `None` | simulated time after which an episode is truncated |
    | `lost_beyond` | `1.0` | m |
    | `goal_as` | `"polar"` | or `"xy"`: x ahead, y to the left |
    | `map_cells` | `64` | n, cells along a side of `map` |
    | `cell` | `0.1` | side of a cell of `map` and of the seen area, m |

    ## Info
    | Key | Type | Content |
    |---|---|---|
    | `T_map_base` | (3,) | the true pose: x, y (m), theta (rad) |
    | `applied` | (2,) | v (m/s), omega (rad/s): the command within the limits |
    | `stamp` | float | of the scan, simulated s |
    | `seconds` | float | simulated time in this episode |
    | `route_left` | float | L of `progress`, m |
    | `reward` | dict | the parts whose sum is the reward: under the name of `reward`, and `collision` |
    | `ending` | str | `collision`, `goal`, `lost` or `time`; empty until then |
    | `slam_pose` | (3,) | where SLAM runs: x, y (m), theta (rad), map frame |
    | `slam_covariance` | (3, 3) | where SLAM runs: of `slam_pose`, map frame; nan in paper mode, which has none |
    | `slam_lost` | bool | where SLAM runs: it says that it is lost |
    | `slam_error` | float | where SLAM runs: from the true position to the estimated one, m |
    | `observation` | `Observation` | what the robot said, whole: scan, odometry, truth, bumpers, sonar |

    Times are simulated ones, so the same seed gives the same `info`. How long SLAM took on the wall's clock is
    ``env.unwrapped.episode.moment.estimate.total_time``, seconds.

    ## Version History
    v0: the first.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012  # as in Env

    def __init__(
        self,
        scenario: str | Path | Scenario = "corridor",
        settings: Sequence[str] = (),
        render_mode: Literal["rgb_array"] | None = None,
        **arguments: Any,
    ) -> None:
        self.config = env_config(arguments)
        world = scenario if isinstance(scenario, Scenario) else load_template(scenario, settings)
        self._template = None if isinstance(world, Scenario) else world
        self.scenario = world if isinstance(world, Scenario) else world.draw()
        self._extent = Extent.of(self.scenario)
        self._require_route()
        views = make_views(self.config, self.scenario, self._extent)
        spaces: Space[Any] = Dict({name: view.space() for name, view in views.items()})
        self.observation_space = spaces
        self.action_space: Space[Any] = action_space()
        self.render_mode = render_mode
        self._top_view: TopView | None = None
        self._robot: SimRobot | None = None
        self._episode: Episode | None = None

    @property
    def robot(self) -> SimRobot:
        """The robot; RobotError before the first reset and after close."""
        if self._robot is None:
            raise RobotError("the environment has no robot yet: call reset() first")
        return self._robot

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
        self._begin(seed)
        self._episode = Episode(self.config, self.scenario, self._extent, seed, self._observe())
        parts = dict.fromkeys((self.config.reward, "collision"), 0.0)
        return self._episode.views(), episode_info(self._episode, Twist2D(), parts, "")

    def step(self, action: Any) -> tuple[ObservationDict, float, bool, bool, dict[str, Any]]:
        """Drive at the speeds of the action until the next scan has come; InputError for what is no such action."""
        episode = self.episode
        applied = self.robot.drive(self._twist(action))
        moment = episode.see(self._observe())
        parts = episode.payment()
        end = termination(moment, self.config)
        info = episode_info(episode, applied, parts, end or ("time" if episode.out_of_time else ""))
        return episode.views(), sum(parts.values()), bool(end), episode.out_of_time, info

    def render(self) -> NDArray[np.uint8] | None:
        """The view from above, (height, width, 3): walls grey, the scan yellow, SLAM's lines blue and its pose orange,
        the true pose dark, the next way-point violet, people sky blue. None without a render mode."""
        if self.render_mode is None:
            return None
        if self._top_view is None:
            self._top_view = TopView(self.scenario, self._extent)
        slam = self.episode.slam
        lines = np.empty((0, 2, 2)) if slam is None else slam.lines.ends
        return self._top_view.frame(self.episode.moment, lines, self.robot.people)

    def close(self) -> None:
        """Free the physics engine; closing twice is allowed."""
        if self._robot is not None:
            self._robot.close()
        self._robot = self._episode = None

    def _begin(self, seed: int) -> None:
        """The same world again, or a new one where the scenario leaves something to chance."""
        if self._template is not None and self._template.random:
            self.close()
            self._enter(self._template.draw(seed))
        if self._robot is None:
            self._robot = SimRobot(self.scenario, seed)
        else:
            self._robot.restart(seed)

    def _enter(self, scenario: Scenario) -> None:
        if scenario.lidar.description != self.scenario.lidar.description:
            raise ScenarioError(f"{scenario.name}: lidar.model is random, and spaces cannot change; settle on one")
        self.scenario, self._extent = scenario, Extent.of(scenario)
        if self._top_view is not None:
            self._top_view.show(scenario, self._extent)

    def _observe(self) -> Observation:
        observation = self.robot.observe()
        if observation is None:
            raise RobotError("the scenario's duration is over: call reset()")
        return observation

    def _twist(self, action: Any) -> Twist2D:
        return (
            twist_action(action)
            if self.config.action == "twist"
            else wheels_action(action, self.scenario.robot.odometry.track)
        )

    def _require_route(self) -> None:
        needs = "reward='progress'" if self.config.reward == "progress" else "observe='goal'"
        needed = self.config.reward == "progress" or "goal" in self.config.observe
        if needed and not self.scenario.route.waypoints:
            raise ScenarioError(
                f"{self.scenario.name}: {needs} needs route.waypoints; add some, or choose reward='coverage' or 'none'"
            )
