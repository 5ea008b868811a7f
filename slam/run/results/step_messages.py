"""Messages of a step, for the log and for topics."""

from collections.abc import Iterator

from slam.files.ros.encoder import Encoder
from slam.files.ros.messages import GROUND_TRUTH, ODOM, SCAN, TF
from slam.run.step import Step


class StepMessages:
    """Encodes each step once, for all users."""

    def __init__(self) -> None:
        self._encoder = Encoder()
        self._step: Step | None = None
        self._messages: dict[str, bytes] = {}

    def of(self, step: Step) -> dict[str, bytes]:
        """Return the messages by topic in the order of sending: the scan comes last."""
        if step is not self._step:
            self._step, self._messages = step, dict(self._encoded(step))
        return self._messages

    def _encoded(self, step: Step) -> Iterator[tuple[str, bytes]]:
        observation, encoder = step.observation, self._encoder
        odometry, scan = observation.odometry, observation.scan
        T_map_odom = step.estimate.T_map_base @ odometry.T_odom_base.inverse()
        links = ("odom", "base_link", odometry.T_odom_base), ("map", "odom", T_map_odom)
        yield TF, encoder.transforms(scan.stamp, *links)
        yield ODOM, encoder.odometry(odometry)
        if observation.T_map_base is not None:
            yield GROUND_TRUTH, encoder.pose(scan.stamp, "map", observation.T_map_base)
        yield SCAN, encoder.scan(scan)
