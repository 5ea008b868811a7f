"""The arguments of a learning environment, checked."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError

from slam.config import Section
from slam.env.occupancy_grid import Extent
from slam.env.rewards import REWARDS, Reward
from slam.env.step_state import ENDS, StepState
from slam.env.views import VIEWS, View, ViewSetup
from slam.errors import ScenarioError
from slam.odometry import Twist2D
from slam.run.gym_arrays import twist_action, wheels_action
from slam.scenario.schema import Scenario
from slam.scenario.settings import one_or_several
from slam.scenario.validation_message import validation_message
from slam.scenario.values import NotNegative, Positive

ViewName = Literal[*VIEWS]  # type: ignore[valid-type]  # the names are those of the table
RewardName = Literal[*REWARDS]  # type: ignore[valid-type]  # the same
EndName = Literal[*ENDS]  # type: ignore[valid-type]  # the same


def _several(names: Any) -> Any:
    """Turn a single name into a list of one."""
    return one_or_several(names) if isinstance(names, str) else names


class EnvConfig(Section):
    """Actions, views, rewards and ends of an environment; the docstring of ``P3DXEnv`` is their manual."""

    action: Literal["twist", "wheels"] = "twist"
    """Meaning of the two numbers of an action."""
    observe: Annotated[tuple[ViewName, ...], BeforeValidator(_several)] = Field(("scan", "odometry"), min_length=1)
    """The keys of an observation."""
    reward: RewardName = "progress"
    collision_penalty: NotNegative = 0.0
    """Subtracted from the reward of every step that ends in a collision."""
    end_on: Annotated[tuple[EndName, ...], BeforeValidator(_several)] = ("collision", "goal")
    """Ends that terminate an episode."""
    max_seconds: Positive | None = None
    """An episode is truncated after this many simulated seconds, at the latest after the scenario's ``duration``."""
    lost_beyond: Positive = 1.0
    """SLAM counts as lost if its pose is farther than this from the true one, metres, if that is known."""
    goal_as: Literal["polar", "xy"] = "polar"
    """Coordinates of the next way-point."""
    map_cells: int = Field(64, ge=8, le=512)
    """Cells along a side of the map crop."""
    cell: float = Field(0.1, ge=0.01)
    """Side of a cell of the map and of the seen area, metres."""

    @property
    def uses_slam(self) -> bool:
        """True if a view, reward or end needs the method; otherwise it does not run."""
        return "lost" in self.end_on or not {"slam_pose", "map"}.isdisjoint(self.observe)

    def twist(self, action: Any, track: float) -> Twist2D:
        """Convert an action to a command; InputError for anything but two finite numbers."""
        return twist_action(action) if self.action == "twist" else wheels_action(action, track)

    def make_views(self, scenario: Scenario, extent: Extent) -> dict[str, View]:
        """Make the views of a new episode in this scenario, whose world has this extent."""
        setup = ViewSetup(scenario, extent, self.cell, self.map_cells, self.goal_as)
        return {name: VIEWS[name](setup) for name in self.observe}

    def make_reward(self, first: StepState, extent: Extent) -> Reward:
        """Make the reward of a new episode, which begins in this state."""
        return REWARDS[self.reward](first, extent, self.cell)

    def ending(self, state: StepState) -> str:
        """Return the name of the first end of ``end_on`` that is true; "" for none."""
        return next((name for name in self.end_on if ENDS[name](state, self.lost_beyond)), "")

    def require_route(self, scenario: Scenario) -> None:
        """Refuse a scenario without way-points if the reward or a view needs them."""
        progress = self.reward == "progress"
        if (progress or "goal" in self.observe) and not scenario.route.waypoints:
            needs = "reward='progress'" if progress else "observe='goal'"
            raise ScenarioError(
                f"{scenario.name}: {needs} needs route.waypoints; add some, or choose reward='coverage' or 'none'"
            )


def env_config(arguments: dict[str, Any]) -> EnvConfig:
    """Check the arguments of ``gymnasium.make``; ScenarioError is one line that names the first wrong one."""
    try:
        return EnvConfig.model_validate(arguments)
    except ValidationError as errors:
        key_path, reason = validation_message(errors, EnvConfig)
        raise ScenarioError(f"environment argument {'.'.join(map(str, key_path))}: {reason}") from errors
