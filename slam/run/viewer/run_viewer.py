"""A watcher that shows a run as it goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slam.run.step import Step
from slam.run.viewer.events import Event, EventWatch
from slam.run.viewer.frame import frame_of
from slam.run.viewer.scene import Scene

if TYPE_CHECKING:  # it imports rerun
    from slam.run.viewer.broadcast import Broadcast


class RunViewer:
    """Turns steps into frames and events."""

    def __init__(self, broadcast: Broadcast, setting: Scene) -> None:
        self._broadcast, self._setting, self._watch = broadcast, setting, EventWatch()
        self._scan, self._stamp = 0, 0.0

    def see(self, step: Step) -> None:
        """Show one step."""
        setting = self._setting
        self._scan, self._stamp = step.index, step.estimate.stamp
        frame = frame_of(step, setting.T_map_odom, setting.T_base_laser, setting.deskew)
        self._broadcast.show(frame, list(self._watch.of(step)))

    def end(self, ending: str, error: Exception | None = None) -> None:
        """Say how the run ended."""
        text = ending if error is None else f"{ending}: {error}"
        self._broadcast.tell(Event(self._scan, self._stamp, "INFO" if error is None else "ERROR", text))
