"""What an agent sees, by name: each view gives its space, and a fresh array of every moment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, Protocol

from gymnasium.spaces import Box
from numpy.typing import NDArray

from slam.env.config import EnvConfig
from slam.env.seen_grid import Extent
from slam.env.step_state import StepState
from slam.env.views.goal import GoalView
from slam.env.views.map import MapView
from slam.env.views.odometry import OdometryView
from slam.env.views.scan import ScanView
from slam.env.views.slam_pose import SlamPoseView
from slam.scenario.schema import Scenario


class View(Protocol):
    """One key of the observations of one episode."""

    def space(self) -> Box:
        """Within which the arrays lie."""
        ...

    def of(self, moment: StepState) -> NDArray[Any]:
        """The array of this moment, which nobody else holds."""
        ...


_VIEWS: Final[dict[str, Callable[[EnvConfig, Scenario, Extent], View]]] = {
    "scan": lambda config, scenario, extent: ScanView(scenario.lidar.description.lidar),
    "odometry": lambda config, scenario, extent: OdometryView(),
    "slam_pose": lambda config, scenario, extent: SlamPoseView(),
    "map": MapView,
    "goal": lambda config, scenario, extent: GoalView(config.goal_as),
}


def make_views(config: EnvConfig, scenario: Scenario, extent: Extent) -> dict[str, View]:
    """The views that the configuration names, for a new episode in the world of this extent."""
    return {name: _VIEWS[name](config, scenario, extent) for name in config.observe}
