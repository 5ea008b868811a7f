"""The last messages of a robot's topics, kept until they are used."""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from slam.files.fields import BadLine
from slam.files.logs.bag_poses import BASES, FrameTree, Mount, is_odometry
from slam.files.ros.decoder import Transform, decode_odometry, decode_transforms
from slam.files.ros.messages import LASER_SCAN, ODOMETRY, RawMessage
from slam.odometry import Odometry, Twist2D
from slam.run.ros_robot.heard_odometry import HeardOdometry
from slam.scenario.ros_config import RosConfig
from slam.topics.names import TF, TF_STATIC
from slam.topics.topic import Bus, Topic

_LOG = logging.getLogger("hopslam.ros")


class HeardTopics:
    """Waiting scans, the oldest dropped if they are too many; odometry; and the mount of the lidar.

    Threads of the bus add to it.
    """

    def __init__(self, bus: Bus, config: RosConfig, kept: int) -> None:
        """Begin to listen; up to ``kept`` scans wait."""
        self.odometry = HeardOdometry()
        self._news = threading.Condition()
        self._scans: deque[RawMessage] = deque(maxlen=kept)
        self._links: dict[str, Transform] = {}
        self._base: str | None = None  # name of the base frame in messages of odometry
        self._garbled = 0
        scan = Topic(config.scan_topic, LASER_SCAN, reliable=config.reliable)
        odometry = Topic(config.odom_topic, ODOMETRY, reliable=config.reliable)
        for topic, heard in (
            (TF_STATIC, self._hear_transforms), (TF, self._hear_transforms),
            (odometry, self._hear_odometry), (scan, self._hear_scan),
        ):  # fmt: skip
            bus.subscribe(topic, self._hearing(topic, heard))

    def next_scan(self, until: float, newest: bool = False) -> RawMessage | None:
        """Take the oldest waiting scan, or the ``newest``; None if none comes before the monotonic time ``until``."""
        with self._news:
            self._news.wait_for(lambda: self._scans, max(0.0, until - time.monotonic()))
            while newest and len(self._scans) > 1:
                self._scans.popleft()
            return self._scans.popleft() if self._scans else None

    def put_back(self, scan: RawMessage) -> None:
        """Put this scan back as the next one."""
        with self._news:
            self._scans.appendleft(scan)

    def mount(self, laser: str, until: float) -> Mount | None:
        """Return the mount of a lidar with this frame, waiting for it until ``until``; None if it is not published.

        LogError if it is tilted.
        """
        with self._news:
            self._news.wait_for(lambda: laser in self._links, max(0.0, until - time.monotonic()))
            return FrameTree(self._links.values()).mount(self._base or BASES[0], laser)

    def _hearing(self, topic: Topic, heard: Callable[[RawMessage], None]) -> Callable[[bytes], None]:
        """Return a function that takes the bytes of a message; the first garbled one causes a warning."""

        def hear(message: bytes) -> None:
            try:
                heard(RawMessage(topic.name, topic.type, "cdr", message, 0))
            except BadLine as fault:
                self._note(topic, fault)

        return hear

    def _note(self, topic: Topic, fault: BadLine) -> None:
        self._garbled += 1
        if self._garbled == 1:
            _LOG.warning("%s: ignored a message that cannot be read: %s", topic.name, fault)

    def _hear_scan(self, raw: RawMessage) -> None:
        with self._news:
            self._scans.append(raw)
            self._news.notify_all()

    def _hear_odometry(self, raw: RawMessage) -> None:
        message = decode_odometry(raw)
        self._base = message.child or BASES[0]
        self.odometry.add(message.odometry)

    def _hear_transforms(self, raw: RawMessage) -> None:
        for link in decode_transforms(raw):
            if is_odometry(link):
                if self._base is None:
                    self.odometry.add(self._with_speed(Odometry(link.stamp, link.pose)))
                continue
            with self._news:
                self._links.setdefault(link.child, link)
                self._news.notify_all()

    def _with_speed(self, odometry: Odometry) -> Odometry:
        """Return the odometry with the speed of the motion that led there."""
        before = self.odometry.last
        if before is None or not odometry.stamp > before.stamp:
            return odometry
        motion = before.T_odom_base.between(odometry.T_odom_base)
        return replace(odometry, twist=Twist2D.from_motion(motion, odometry.stamp - before.stamp))
