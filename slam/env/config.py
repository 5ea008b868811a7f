"""The arguments of a learning environment, checked."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError

from slam.config import Section
from slam.errors import ScenarioError
from slam.scenario.settings import one_or_several
from slam.scenario.validation_message import validation_message
from slam.scenario.values import NotNegative, Positive

ViewName = Literal["scan", "odometry", "slam_pose", "map", "goal"]
RewardName = Literal["progress", "coverage", "none"]
EndName = Literal["collision", "goal", "lost"]


def _several(names: Any) -> Any:
    """A bare name is a list of one."""
    return one_or_several(names) if isinstance(names, str) else names


class EnvConfig(Section):
    """Actions, views, rewards and ends of an environment; the docstring of ``P3DXEnv`` is their manual."""

    action: Literal["twist", "wheels"] = "twist"
    """What the two numbers of an action are."""
    observe: Annotated[tuple[ViewName, ...], BeforeValidator(_several)] = Field(("scan", "odometry"), min_length=1)
    """The keys of an observation."""
    reward: RewardName = "progress"
    collision_penalty: NotNegative = 0.0
    """Taken off the reward of every step that ends in a collision."""
    end_on: Annotated[tuple[EndName, ...], BeforeValidator(_several)] = ("collision", "goal")
    """What terminates an episode."""
    max_seconds: Positive | None = None
    """An episode is truncated after this many simulated seconds; never later than the scenario's ``duration``."""
    lost_beyond: Positive = 1.0
    """SLAM counts as lost when its pose is farther than this from the true one, metres, where that is known."""
    goal_as: Literal["polar", "xy"] = "polar"
    """How the next way-point is told."""
    map_cells: int = Field(64, ge=8, le=512)
    """Cells along a side of the map crop."""
    cell: float = Field(0.1, ge=0.01)
    """Side of a cell of the map and of the seen area, metres."""

    @property
    def uses_slam(self) -> bool:
        """Whether anything here depends on the method: without need it does not run."""
        return "lost" in self.end_on or not {"slam_pose", "map"}.isdisjoint(self.observe)


def env_config(arguments: dict[str, Any]) -> EnvConfig:
    """The arguments as given to ``gymnasium.make``; ScenarioError is one line that names the first wrong one."""
    try:
        return EnvConfig.model_validate(arguments)
    except ValidationError as errors:
        location, reason = validation_message(errors, EnvConfig)
        raise ScenarioError(f"environment argument {'.'.join(map(str, location))}: {reason}") from errors
