"""The buses of one run, and the commands received on them."""

from collections.abc import Sequence
from typing import Self

from slam.files.fields import BadLine
from slam.files.ros.decoder import decode_unsure_pose
from slam.files.ros.messages import RawMessage
from slam.line_localizer import LineLocalizer, LocalizeThenMap
from slam.run.estimator import Estimator
from slam.run.results.step_messages import StepMessages
from slam.run.topics.run_topics import RunTopics
from slam.run.topics.slam_topics import SlamTopics
from slam.run.topics.velocity_commands import VelocityCommands
from slam.scenario.schema import Scenario
from slam.topics.names import INITIAL_POSE
from slam.topics.several import SeveralBuses
from slam.topics.topic import Bus


class TopicSession:
    """Buses that are open during its block, for one run."""

    def __init__(self, buses: Sequence[Bus], pace: float | None = None) -> None:
        self.bus = SeveralBuses(buses)
        self.pace = pace
        """Speed relative to real time, if the run is simulated or recorded; 0 for one scan per command; None for 1."""
        self.commands = VelocityCommands()
        """Velocities from outside."""
        self._watcher: SlamTopics | None = None

    def __enter__(self) -> Self:
        self.bus.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        if self._watcher is not None:
            self._watcher.close()
        self.bus.__exit__(*error)

    def on_time(self, stamp: float) -> None:
        """Publish the time between two scans."""
        if self._watcher is not None:
            self._watcher.on_time(stamp)

    def watcher(self, slam: Estimator, scenario: Scenario, messages: StepMessages) -> SlamTopics:
        """Make the watcher that publishes the run, and keep it until the session ends."""
        self._watcher = self.make_watcher(slam, scenario, messages)
        return self._watcher

    def make_watcher(self, slam: Estimator, scenario: Scenario, messages: StepMessages) -> SlamTopics:
        """Make a watcher that publishes a run."""
        return RunTopics(self.bus, slam, scenario, messages)

    def hear_commands(self) -> None:
        """Take velocities from now on."""
        self.commands.listen(self.bus)

    def hear_initial_pose(self, slam: Estimator) -> None:
        """Let ``/initialpose`` set the robot's pose, if the method localises in a map."""
        if isinstance(slam, LineLocalizer | LocalizeThenMap):
            self.bus.subscribe(INITIAL_POSE, lambda message: _place(slam, message))


def _place(slam: LineLocalizer | LocalizeThenMap, message: bytes) -> None:
    """Set the robot's pose, if the message is a pose in the map; any other is ignored."""
    try:
        given = decode_unsure_pose(RawMessage(INITIAL_POSE.name, INITIAL_POSE.type, "cdr", message, 0))
    except BadLine:
        return
    if given.frame == "map":
        slam.place(given.pose)
