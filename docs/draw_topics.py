"""Draw docs/topics.png from the messages of a run alone: ``python docs/draw_topics.py``, or ``make pictures``.

It is what the 3D panel of the Foxglove app gets, decoded by rosbags and placed by the transforms.
"""

from collections.abc import Callable
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, Self

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from slam.files.ros.decoder import decode_scan, decode_transforms, decode_unsure_pose
from slam.files.ros.messages import RawMessage, ros2_types
from slam.pose import Pose2D
from slam.run.experiment_setup import on_topics, scenario_experiment
from slam.run.topics.topic_session import TopicSession
from slam.scenario.file import load_scenario
from slam.topics.topic import Topic

PICTURE: Final = Path(__file__).parent / "topics.png"
GREYS: Final = {-1: 0.8, 0: 1.0, 100: 0.1}
"""Grey of the cells of an occupancy grid."""


class LastMessages:
    """A bus that keeps the last message of each topic, and each transform."""

    def __init__(self) -> None:
        self._last: dict[str, RawMessage] = {}
        self._poses: dict[str, tuple[str, Pose2D]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def publish(self, topic: Topic, stamp: float, message: bytes) -> None:
        """Keep a message."""
        raw = RawMessage(topic.name, topic.type, "cdr", message, round(1e9 * stamp))
        self._last[topic.name] = raw
        if topic.name in ("/tf", "/tf_static"):
            self._poses |= {link.child: (link.frame, link.pose) for link in decode_transforms(raw)}

    def subscribe(self, topic: Topic, heard: Callable[[bytes], None]) -> None:
        """Ignore the listener: no other program sends messages here."""

    def raw(self, topic: str) -> RawMessage:
        """The last message of a topic, as it was sent."""
        return self._last[topic]

    def message(self, topic: str) -> Any:
        """The last message of a topic."""
        return ros2_types().deserialize_cdr(self._last[topic].data, self._last[topic].type)

    def pose(self, frame: str) -> Pose2D:
        """Pose of a frame in the map."""
        if frame == "map":
            return Pose2D()
        parent, pose = self._poses[frame]
        return self.pose(parent) @ pose


def draw(messages: LastMessages) -> Figure:
    """Draw the map, its lines, the robot and its scan."""
    figure, axes = plt.subplots(figsize=(7.0, 5.2), layout="constrained")
    draw_grid(axes, messages.message("/map"))
    (marker,) = messages.message("/lines").markers
    ends = np.array([(point.x, point.y) for point in marker.points]).reshape(-1, 2, 2)
    axes.add_collection(LineCollection(list(ends), colors="#d9261a", linewidths=1.2, label="/lines"))
    points = messages.pose("laser").transform(decode_scan(messages.raw("/scan")).points())
    axes.plot(*points.T, ".", color="#2a9df4", markersize=2.5, label="/scan")
    robot = decode_unsure_pose(messages.raw("/slam_pose")).pose
    axes.quiver(robot.x, robot.y, np.cos(robot.theta), np.sin(robot.theta), color="#e06c00", scale=18.0, width=0.006)
    axes.plot(robot.x, robot.y, "o", color="#e06c00", label="/slam_pose")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.legend(loc="upper left")
    return figure


def draw_grid(axes: Axes, grid: Any) -> None:
    """Draw an occupancy grid at its origin."""
    info, cells = grid.info, grid.data.reshape(grid.info.height, grid.info.width)
    x, y = info.origin.position.x, info.origin.position.y
    shades = np.select([cells == value for value in GREYS], list(GREYS.values()))
    extent = (x, x + info.resolution * info.width, y, y + info.resolution * info.height)
    axes.imshow(shades, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)


def main() -> None:
    """Drive the office, and draw what was published last."""
    messages = LastMessages()
    with TemporaryDirectory() as folder, TopicSession([messages], pace=inf) as topics:
        experiment = scenario_experiment(load_scenario("office_loop", ["physics.engine=plan"]))
        on_topics(experiment, topics).run(Path(folder) / "run", pictures=False)
    draw(messages).savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
