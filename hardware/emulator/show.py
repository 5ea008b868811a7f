"""The emulated world in the viewer: where the robot really is, and what its lidar sees."""

from __future__ import annotations

import numpy as np

from hardware.emulator.emulator_state import EmulatorState
from slam.pose import Pose2D
from slam.run.viewer.broadcast import Broadcast
from slam.run.viewer.palette import NO_SEGMENT
from slam.run.viewer.scene import Event, Frame, Scene
from slam.scenario.schema import Scenario


def setting_of(scenario: Scenario) -> Scene:
    """The true walls, no map, and no curves: nothing is estimated."""
    start, mount = scenario.robot.start.pose, scenario.lidar.mount.pose
    return Scene(mount, start, outlines=tuple(scenario.world.outlines(scenario.lidar.height)), plots=())


class Show:
    """Sends one look after another."""

    def __init__(self, broadcast: Broadcast, setting: Scene) -> None:
        self._broadcast, self._setting = broadcast, setting
        self._index, self._stalled = 0, False

    def look(self, seen: EmulatorState) -> None:
        """Send one."""
        events = []
        if seen.stalled is not self._stalled:
            self._stalled = seen.stalled
            words = "stalled: a wheel cannot turn" if seen.stalled else "the wheels turn again"
            events.append(Event(self._index, seen.stamp, "WARN", words))
        self._broadcast.show(self._frame(seen), events)
        self._index += 1

    def _frame(self, seen: EmulatorState) -> Frame:
        odometry: Pose2D = self._setting.T_map_odom @ seen.T_odom_base
        points = (seen.T_map_base @ self._setting.T_base_laser).transform(seen.points)
        grey = np.full(len(points), NO_SEGMENT, np.uint32)
        return Frame(
            self._index, seen.stamp, None, odometry, seen.T_map_base, points, grey, np.empty((0, 2, 2)), grey[:0]
        )
