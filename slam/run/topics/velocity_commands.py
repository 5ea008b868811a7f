"""Velocity commands from outside, and a pilot that obeys them."""

import logging
from threading import Condition
from time import monotonic
from typing import Final

from slam.files.fields import BadLine
from slam.files.ros.decoder import decode_twist
from slam.files.ros.messages import RawMessage
from slam.odometry import Twist2D
from slam.pose import Pose2D
from slam.run.pilots import Pilot
from slam.scan import LaserScan
from slam.topics.names import CMD_VEL, STAMPED_CMD_VEL
from slam.topics.topic import Bus, Topic

_LOG: Final = logging.getLogger("hopslam.topics")
SILENCE: Final = 0.5
"""Seconds without a command after which the robot stops."""
_LARGEST: Final = 1024
"""Longest message, bytes; no velocity is longer, whatever its frame name."""


class VelocityCommands:
    """The last velocity received on ``/cmd_vel``; buses call it in their own threads."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._twist, self._at = Twist2D(), 0.0
        self.count = 0
        """Number of commands so far."""
        self.garbage = 0
        """Number of invalid messages."""

    def listen(self, bus: Bus) -> None:
        """Listen to the topic with both of its types."""
        bus.subscribe(CMD_VEL, lambda message: self.hear(CMD_VEL, message))
        bus.subscribe(STAMPED_CMD_VEL, lambda message: self.hear(STAMPED_CMD_VEL, message))

    def hear(self, topic: Topic, message: bytes) -> None:
        """Take a message; an invalid one is ignored, and the first one causes a warning."""
        try:
            twist = _twist(topic, message)
        except BadLine as fault:
            with self._changed:
                self.garbage += 1
                first = self.garbage == 1
            if first:
                _LOG.warning("%s: ignored a message that is not a velocity: %s", topic.name, fault)
            return
        with self._changed:
            self._twist, self._at, self.count = twist, monotonic(), self.count + 1
            self._changed.notify_all()

    @property
    def twist(self) -> Twist2D:
        """Last command; zero after half a second without one."""
        with self._changed:
            return self._twist if monotonic() - self._at < SILENCE else Twist2D()

    @property
    def last(self) -> tuple[int, Twist2D]:
        """Number of commands, and the last of them, whatever its age."""
        with self._changed:
            return self.count, self._twist

    def wait_for_more(self, count: int, timeout: float) -> bool:
        """Wait until there are more commands than ``count``; False after ``timeout`` seconds."""
        with self._changed:
            return self._changed.wait_for(lambda: self.count > count, timeout)


def _twist(topic: Topic, message: bytes) -> Twist2D:
    if len(message) > _LARGEST:
        raise BadLine("too long")
    return decode_twist(RawMessage(topic.name, topic.type, "cdr", message, 0))


class CommandedPilot:
    """Drives as commanded, from the first command on; before that, as another pilot does."""

    def __init__(self, commands: VelocityCommands, until_commanded: Pilot) -> None:
        self._commands, self._until_commanded = commands, until_commanded

    @property
    def progress(self) -> float:
        """Progress of the other pilot."""
        return self._until_commanded.progress

    def command(self, T_map_base: Pose2D, scan: LaserScan) -> Twist2D | None:
        """Return the last velocity from outside; before the first one, the other pilot's command."""
        return self._commands.twist if self._commands.count else self._until_commanded.command(T_map_base, scan)
