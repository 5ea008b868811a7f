"""``--ros``, ``--foxglove`` and ``--pace``: the buses on which a run is published, and its pace."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.run.ros_robot.robot import TopicRobot
from slam.run.topics.follower_topics import FollowerSession
from slam.run.topics.topic_session import TopicSession
from slam.topics.foxglove_bus import PORT, FoxgloveBus
from slam.topics.ros_bus import open_ros_bus
from slam.topics.topic import Bus


@dataclass(frozen=True, slots=True)
class TopicChoice:
    """Buses of a run; none by default."""

    ros: bool = False
    """ROS 2, with the settings of its environment variables."""
    foxglove: bool | int | str = False
    """The Foxglove app: True for the usual port of this machine, or else a port, or ``HOST:PORT``."""
    pace: float | None = None
    """Speed of a simulated or recorded run relative to the wall clock; inf for as fast as possible, 0 for one scan per
    command, None for 1."""
    follows: TopicRobot | None = None
    """A robot that others drive and that publishes its own topics; None for a run that drives its robot."""

    def __bool__(self) -> bool:
        return self.ros or self.foxglove is not False

    @contextmanager
    def session(self, console: Terminal) -> Iterator[TopicSession | None]:
        """Open the buses, and print their addresses; None without any. InputError if that fails."""
        self._check_pace()
        foxglove = None if self.foxglove is False else FoxgloveBus(*parse_address(self.foxglove))
        ros = open_ros_bus() if self.ros else None
        buses: list[Bus] = [bus for bus in (foxglove, ros) if bus is not None]
        if not buses:
            yield None
            return
        pace, robot = self.pace, self.follows
        with TopicSession(buses, pace) if robot is None else FollowerSession(buses, robot) as topics:
            if foxglove is not None:
                console.print(f"Foxglove: open {foxglove.address} in the app")
            yield topics
            if topics.commands.garbage:
                console.warn(f"/cmd_vel: {topics.commands.garbage} messages were ignored: they were not velocities")

    def _check_pace(self) -> None:
        if self.pace is not None and not self:
            raise InputError(f"--pace {self.pace:g} is for a run on topics; add --ros or --foxglove")
        if self.pace is not None and not self.pace >= 0.0:
            raise InputError(f"--pace {self.pace:g}: time does not run backwards; give a number of 0 or more, or inf")


def parse_address(given: bool | int | str) -> tuple[str, int]:
    """Return the host and port of ``[HOST:]PORT``, and the usual ones for True; InputError for another form."""
    host, _, port = str(PORT if given is True else given).rpartition(":")
    if not port.isdecimal() or int(port) > 65535:
        raise InputError(f"--foxglove-at {given}: no address; give PORT or HOST:PORT, such as 0.0.0.0:{PORT}")
    return host.strip("[]") or "127.0.0.1", int(port)
