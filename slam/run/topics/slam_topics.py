"""The knowledge of SLAM on topics: the pose of the robot, the map and its lines."""

from abc import abstractmethod
from math import inf
from pathlib import Path
from time import monotonic

from slam.closing import Closing
from slam.files.ros.live_encoder import LiveEncoder
from slam.pose import FloatArray
from slam.run.estimator import DeadReckoning, Estimator
from slam.run.occupancy import occupancy
from slam.run.results.run_record import RunRecord
from slam.run.step import Step
from slam.run.topics.map_topics import PERIOD, MapNews, MapTopics
from slam.scenario.schema import Scenario
from slam.topics import names
from slam.topics.topic import Bus


class SlamTopics(Closing):
    """A watcher that publishes what is estimated; dead reckoning has no map, and nothing of it is published."""

    def __init__(self, bus: Bus, slam: Estimator, scenario: Scenario) -> None:
        self._bus, self._slam, self._encoder = bus, slam, LiveEncoder()
        self._map_topics = None if isinstance(slam, DeadReckoning) else MapTopics(bus, scenario.slam, slam.T_base_laser)
        self._stamp, self._lines_due = -inf, 0.0

    @abstractmethod
    def on_step(self, step: Step) -> None:
        """Publish one step."""

    def publish_estimate(self, step: Step) -> None:
        """Publish the pose of a step, and the map and the lines where they have changed and it is time."""
        if self._map_topics is not None:
            estimate, self._stamp = step.estimate, step.observation.scan.stamp
            pose = self._encoder.unsure_pose(self._stamp, estimate.T_map_base, estimate.covariance)
            self._bus.publish(names.SLAM_POSE, self._stamp, pose)
            self._map_topics.add(MapNews(step, self._lines_now()))

    def show_end(self, folder: Path) -> None:
        """Publish the map of the run that is in the folder, as it is known in the end and as it is exported."""
        if self._map_topics is not None and self._stamp > -inf:
            self._map_topics.close()
            record = RunRecord.open(folder)
            self._map_topics.send_map(self._stamp, occupancy(record))
            self._map_topics.send_lines(self._stamp, record.walls)

    def close(self) -> None:
        """End the thread of the map."""
        if self._map_topics is not None:
            self._map_topics.close()

    def _lines_now(self) -> FloatArray | None:
        """The lines of the map, where it is time to look at them."""
        if monotonic() < self._lines_due:
            return None
        self._lines_due = monotonic() + PERIOD
        return self._slam.lines.ends
