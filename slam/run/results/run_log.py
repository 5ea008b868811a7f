"""``log.mcap``: the raw record of a run, every scan with the odometry, the estimate and the truth at its stamp."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from slam.files.ros.encoder import Encoder, nanoseconds
from slam.files.ros.mcap_writer import McapWriter
from slam.files.ros.topics import GROUND_TRUTH, ODOM, SCAN, TF, TF_STATIC
from slam.pose import Pose2D
from slam.run.step import Step

LOG: Final = "log.mcap"
_SCANS_A_CHUNK: Final = 8
"""At 10 Hz less than a second of a run is lost when it is killed."""
_BYTES_BESIDE: Final = 1300
"""Of a scan's other messages."""


class RunLog:
    """A watcher that appends every step to ``log.mcap``; of a step, the scan comes last."""

    def __init__(self, folder: Path, T_base_laser: Pose2D) -> None:
        self._path, self._T_base_laser = folder / LOG, T_base_laser
        self._encoder = Encoder()
        self._writer: McapWriter | None = None

    def see(self, step: Step) -> None:
        """Write one step."""
        observation, encoder = step.observation, self._encoder
        odometry, scan = observation.odometry, observation.scan
        writer = self._writer or self._begin(step)
        time = nanoseconds(scan.stamp)
        T_map_odom = step.estimate.T_map_base @ odometry.T_odom_base.inverse()
        links = ("odom", "base_link", odometry.T_odom_base), ("map", "odom", T_map_odom)
        writer.write(TF, time, encoder.transforms(scan.stamp, *links))
        writer.write(ODOM, time, encoder.odometry(odometry))
        if observation.T_map_base is not None:
            writer.write(GROUND_TRUTH, time, encoder.pose(scan.stamp, "map", observation.T_map_base))
        writer.write(SCAN, time, encoder.scan(scan))
        writer.flush()

    def close(self) -> None:
        """Write the index, and put everything on the disk."""
        if self._writer is not None:
            self._writer.close()

    def _begin(self, step: Step) -> McapWriter:
        """The file, with the mount of the lidar in it; its chunks are as large as the first scan asks."""
        scan = step.observation.scan
        chunk = _SCANS_A_CHUNK * (4 * len(scan.ranges) + _BYTES_BESIDE)
        self._writer = McapWriter(self._path, self._encoder, chunk)
        mount = self._encoder.transforms(scan.stamp, ("base_link", "laser", self._T_base_laser))
        self._writer.write(TF_STATIC, nanoseconds(scan.stamp), mount)
        return self._writer
