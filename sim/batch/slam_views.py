"""Results of SLAM for the robots of a batch, as arrays: observations, keys of ``info``, and the end ``lost``."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sim.batch.robots import BatchObservation, Robots
from sim.batch.slam_pool import Arrays, Estimated, ScanOfRobot, SlamPool, SlamTask
from sim.batch.worlds import Timing
from slam.closing import Closing
from slam.env.config import EnvConfig
from slam.odometry import Odometry, Twist2D
from slam.pose import Pose2D
from slam.scan import LaserScan
from slam.scenario.schema import Scenario


class SlamViews(Closing):
    """The views ``slam_pose`` and ``map``, and the keys of ``info`` that begin with ``slam_``; fresh in every step."""

    def __init__(self, config: EnvConfig, scenarios: Sequence[Scenario], timing: Timing, processes: int) -> None:
        wanted = tuple(name for name in ("slam_pose", "map") if name in config.observe)
        changes = {"observe": wanted or ("slam_pose",), "reward": "none"}
        self._pool = SlamPool(processes, SlamTask(config.model_copy(update=changes), scenarios))
        self._scenario, self._timing, self._lost_beyond = scenarios[0], timing, config.lost_beyond
        self.views: Arrays = {}
        self.info: Arrays = {}

    def update(
        self, begins: NDArray[np.bool_], continues: NDArray[np.bool_], robots: Robots, seen: BatchObservation
    ) -> None:
        """Run SLAM on the scans of these robots in this step."""
        answers = self._pool.estimate(list(self._new_scans(begins, continues, robots, seen)))
        self.views = _updated(self.views, len(begins), answers, "views")
        self.info = _updated(self.info, len(begins), answers, "info")

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Mask of the robots whose SLAM is lost: it reports that itself, or its error exceeds ``lost_beyond``."""
        return np.asarray(self.info["slam_lost"] | (self.info["slam_error"] > self._lost_beyond))

    def close(self) -> None:
        self._pool.close()

    def _new_scans(
        self, begins: NDArray[np.bool_], continues: NDArray[np.bool_], robots: Robots, seen: BatchObservation
    ) -> Iterator[ScanOfRobot]:
        lidar, config, timing = self._scenario.lidar.description.lidar, self._scenario.lidar, self._timing
        for i in np.flatnonzero(begins | continues).tolist():
            beams, begin = int(seen.turns[i, 0]), float(seen.turns[i, 1])
            share = lidar.beams / beams
            stamp = float((robots.turns[i] - 1) * timing.scan_time + timing.controls_before * timing.period)
            scan = LaserScan(
                stamp, lidar.angle_min + begin, lidar.angle_increment * share, lidar.range_min, lidar.range_max,
                np.round(seen.ranges[i, :beams], 6), config.time_increment * share, lidar.scan_time,
            )  # fmt: skip
            x, y, theta, v, omega = seen.odometry[i].tolist()
            odometry = Odometry(stamp, Pose2D(x, y, theta), Twist2D(v, omega))
            seed = int(robots.base["stream"][i] >> np.uint64(33)) if begins[i] else None  # 31 bits of its random stream
            yield ScanOfRobot(i, int(robots.world[i]), seed, scan, odometry, Pose2D.from_array(seen.pose[i]))


def _updated(before: Arrays, count: int, answers: Sequence[Estimated], part: str) -> Arrays:
    """Copy the arrays of all robots, and write the rows of those that SLAM has answered for."""
    after = {key: rows.copy() for key, rows in before.items()}
    for answer in answers:
        row: Arrays = getattr(answer, part)
        for key, value in row.items():
            if key not in after:
                after[key] = np.zeros((count, *value.shape), value.dtype)
            after[key][answer.robot] = value
    return after
