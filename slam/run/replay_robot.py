"""A recorded run with the interface of a robot: it drives as recorded."""

from pathlib import Path

from slam.closing import Closing
from slam.errors import RobotError
from slam.files.logs import Log, read_log
from slam.odometry import Twist2D
from slam.robot import Observation, Robot


class ReplayRobot(Closing):
    """Plays a log from its first scan to its last, without waiting; ``len()`` is the number of scans.

    Made from a path, or from a log in memory; LogError if the path holds none that can be read. The true pose is known
    if the log has it.
    """

    def __init__(self, log: Log | str | Path) -> None:
        self.log = log if isinstance(log, Log) else read_log(log)
        self.T_base_laser = self.log.T_base_laser
        self._observed = 0
        self._closed = False

    def __len__(self) -> int:
        return len(self.log)

    def close(self) -> None:
        """End the replay; closing twice is allowed."""
        self._closed = True

    def observe(self, timeout: float = 1.0) -> Observation | None:
        """Return the next scan, at once; None after the last one. RobotError after close."""
        self._check_open()
        index = self._observed
        if index == len(self.log):
            return None
        self._observed += 1
        return Observation(self.log.scan(index), self.log.odometry(index), self.log.truth(index))

    def drive(self, command: Twist2D) -> Twist2D:
        """Return the recorded mean velocity from the last observed scan to the next one, whatever the command.

        Zero before the first and after the last. RobotError after close.
        """
        self._check_open()
        return self.log.twist(self._observed - 1)

    def _check_open(self) -> None:
        if self._closed:
            raise RobotError("this replay is closed; open the log again to play it once more")


_: type[Robot] = ReplayRobot
