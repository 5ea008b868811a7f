"""The emulated world in the viewer: the robot's true pose, and the points that its lidar sees."""

from __future__ import annotations

import numpy as np

from hardware.emulator.emulator import EmulatorState
from slam.pose import Pose2D
from slam.run.viewer.broadcast import Broadcast
from slam.run.viewer.events import Event
from slam.run.viewer.frame import Frame
from slam.run.viewer.palette import NO_SEGMENT
from slam.run.viewer.scene import Scene
from slam.scenario.schema import Scenario


def emulator_scene(scenario: Scenario) -> Scene:
    """Return a scene of the true walls, without a map and curves, as nothing is estimated."""
    start, mount = scenario.robot.start.pose, scenario.lidar.mount.pose
    return Scene(mount, start, outlines=tuple(scenario.world.outlines(scenario.lidar.height)), plots=())


class EmulatorView:
    """Sends one state after another to the viewer."""

    def __init__(self, broadcast: Broadcast, scene: Scene) -> None:
        self._broadcast, self._scene = broadcast, scene
        self._index, self._stalled = 0, False

    def show(self, state: EmulatorState) -> None:
        """Send a state, and an event where the wheels stall or turn again."""
        events = []
        if state.stalled is not self._stalled:
            self._stalled = state.stalled
            words = "stalled: a wheel cannot turn" if state.stalled else "the wheels turn again"
            events.append(Event(self._index, state.stamp, "WARN", words))
        self._broadcast.show(self._frame(state), events)
        self._index += 1

    def _frame(self, state: EmulatorState) -> Frame:
        odometry: Pose2D = self._scene.T_map_odom @ state.T_odom_base
        points = (state.T_map_base @ self._scene.T_base_laser).transform(state.points)
        grey = np.full(len(points), NO_SEGMENT, np.uint32)
        return Frame(
            self._index, state.stamp, None, odometry, state.T_map_base, points, grey, np.empty((0, 2, 2)), grey[:0]
        )
