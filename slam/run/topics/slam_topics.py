"""Topics of SLAM: the pose of the robot, the map and its lines."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path
from time import monotonic

from slam.closing import Closing
from slam.files.ros.live_encoder import LiveEncoder
from slam.pose import FloatArray
from slam.run.estimator import DeadReckoning, Estimator
from slam.run.results.run_record import RunRecord
from slam.run.results.step_messages import StepMessages
from slam.run.step import Step
from slam.run.topics.map_topics import PERIOD, MapTopics
from slam.run.topics.worker_thread import WorkerThread
from slam.scenario.schema import Scenario
from slam.topics import names
from slam.topics.topic import Bus


@dataclass(frozen=True, slots=True, eq=False)
class StepNews:
    """A step, as the publishing thread needs it."""

    step: Step
    messages: Mapping[str, bytes]
    """Messages, by topic, that are also written to the log of the run."""
    ends: FloatArray | None
    """Lines of the map (N, 2, 2), if they are due."""


class SlamTopics(Closing):
    """Watcher that publishes estimates; a run by dead reckoning has no map, and publishes no estimates.

    The loop only queues the items; a thread publishes them in the same order.
    """

    def __init__(self, bus: Bus, slam: Estimator, scenario: Scenario, messages: StepMessages) -> None:
        self._bus, self._slam, self._encoder, self._step_messages = bus, slam, LiveEncoder(), messages
        self._map_topics = None if isinstance(slam, DeadReckoning) else MapTopics(bus, scenario.slam, slam.T_base_laser)
        self._stamp, self._lines_due = -inf, 0.0
        self._thread: WorkerThread[StepNews | float] = WorkerThread("topics", self._publish)

    @abstractmethod
    def publish(self, news: StepNews) -> None:
        """Publish one step."""

    def on_step(self, step: Step) -> None:
        """Queue one step."""
        self._thread.put(StepNews(step, self._step_messages.of(step), self._lines_now()))

    def on_time(self, stamp: float) -> None:
        """Queue the time between two steps."""
        self._thread.put(stamp)

    def publish_time(self, stamp: float) -> None:
        """Publish the time."""
        self._bus.publish(names.CLOCK, stamp, self._encoder.clock(stamp))

    def publish_estimate(self, news: StepNews) -> None:
        """Publish the pose of a step, and map and lines if they have changed and are due."""
        if self._map_topics is not None:
            estimate, self._stamp = news.step.estimate, news.step.observation.scan.stamp
            pose = self._encoder.unsure_pose(self._stamp, estimate.T_map_base, estimate.covariance)
            self._bus.publish(names.SLAM_POSE, self._stamp, pose)
            self._map_topics.add(news.step, news.ends)

    def show_end(self, folder: Path) -> None:
        """Publish the final map of the run in the folder, as it is exported."""
        self.close()
        if self._map_topics is not None and self._stamp > -inf:
            self._map_topics.send_end(self._stamp, RunRecord.open(folder))

    def close(self) -> None:
        """Publish the waiting items, and end the threads; closing twice is allowed."""
        self._thread.close()
        if self._map_topics is not None:
            self._map_topics.close()

    def _publish(self, news: StepNews | float) -> None:
        if isinstance(news, StepNews):
            self.publish(news)
        else:
            self.publish_time(news)

    def _lines_now(self) -> FloatArray | None:
        """Return the lines of the map, if they are due."""
        if self._map_topics is None or monotonic() < self._lines_due:
            return None
        self._lines_due = monotonic() + PERIOD
        return self._slam.lines.ends
