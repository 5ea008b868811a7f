"""``render_mode="human"``: an environment in the window of the rerun viewer."""

from contextlib import ExitStack

import numpy as np

from slam.console.terminal import Terminal
from slam.env.episode import Episode
from slam.line_slam import Estimate
from slam.odometry import Twist2D
from slam.run.step import Step
from slam.run.viewer.live_run import RunViewer
from slam.run.viewer.rerun_program import data_address, has_display, is_listening
from slam.run.viewer.scene import Scene
from slam.run.viewer.viewers import GRPC_PORT, Viewers


class RerunWindow:
    """Shows each episode as ``hopslam run --rerun spawn`` does, in its own recording.

    Nothing waits for the viewer. Without a screen, a single warning is printed, and nothing is shown.
    """

    def __init__(self) -> None:
        self._console = Terminal(stderr=True)
        self._there = has_display() or is_listening(data_address(GRPC_PORT))
        if not self._there:
            self._console.print('render_mode="human": no screen here, nothing is shown; choose "rgb_array"')
        self._episode = ExitStack()
        self._viewer: RunViewer | None = None

    def begin(self, episode: Episode) -> None:
        """Begin the recording of an episode, with its first state."""
        self.close()
        scene = _scene(episode)
        broadcast = Viewers("spawn", self._console).open(scene) if self._there else None
        if broadcast is not None:
            self._viewer = RunViewer(self._episode.enter_context(broadcast), scene)
            self.show(episode, Twist2D())

    def show(self, episode: Episode, applied: Twist2D) -> None:
        """Show the present state of the episode."""
        state = episode.state
        if self._viewer is not None:
            estimate = state.estimate or Estimate(state.observation.scan.stamp, state.T_map_base)
            self._viewer.on_step(Step(episode.turns - 1, state.observation, estimate, applied, 0.0))

    def close(self) -> None:
        """End the recording; the window stays."""
        self._viewer = None
        self._episode.close()


def _scene(episode: Episode) -> Scene:
    scenario = episode.scenario
    outlines = tuple(scenario.world.outlines(scenario.lidar.height))
    waypoints = scenario.route.waypoints
    route = np.array([(episode.start.x, episode.start.y), *waypoints]) if waypoints else None
    return Scene(scenario.lidar.mount.pose, episode.start, episode.slam, scenario.slam.deskew, outlines, route)
