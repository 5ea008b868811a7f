"""The log of a run as CARMEN text: ``PARAM``, and for each scan ``ODOM``, ``TRUEPOS`` and ``ROBOTLASER1``.

Values without a field in these messages are in ``PARAM hopslam_...`` lines, which other readers ignore: see
slam/files/logs/carmen_message.py. With them, a replay gives the same run.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from slam.files.atomic_files import atomic_file
from slam.files.logs.carmen_message import CarmenParams
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.results.run_record import RunRecord

_HOST: Final = "hopslam"
_STEP: Final = 1e-6
"""Metres by which a reading at exactly the range limit is shortened, as that means no echo in CARMEN."""


def write_carmen(record: RunRecord, out: Path) -> None:
    """Write metres and radians; poses are those of the odometry, in its own frame."""
    with atomic_file(out) as draft, draft.open("w", encoding="ascii") as file:
        for index, seen in enumerate(record.observations()):
            if index == 0:
                file.writelines(_params(record, seen))
            file.writelines(_messages(seen, record.T_base_laser))


def _params(record: RunRecord, first: Observation) -> Iterator[str]:
    scan = first.scan
    start = record.start
    params = CarmenParams(scan.time_increment, scan.range_min, start.x, start.y, start.theta)
    for name, value in params._asdict().items():
        yield f"PARAM hopslam_{name} {value!r} {_times(scan.stamp)}\n"


def _messages(seen: Observation, T_base_laser: Pose2D) -> Iterator[str]:
    odometry, times = seen.odometry, _times(seen.scan.stamp)
    pose, twist = _pose(odometry.T_odom_base), f"{odometry.twist.linear:.9f} {odometry.twist.angular:.9f}"
    yield f"ODOM {pose} {twist} 0 {times}\n"
    if seen.T_map_base is not None:
        yield f"TRUEPOS {_pose(seen.T_map_base)} {pose} {times}\n"
    laser = _pose(odometry.T_odom_base @ T_base_laser)
    yield f"ROBOTLASER1 {_scan(seen)} 0 {laser} {pose} {twist} 0 0 0 {times}\n"


def _scan(seen: Observation) -> str:
    """Format ``type start fov resolution max_range accuracy remission_mode n ranges[n]``.

    0 m for an invalid reading.
    """
    scan = seen.scan
    reach = scan.range_max
    measured = np.minimum(scan.ranges, reach - _STEP)
    ranges = np.where(scan.echoes, measured, np.where(scan.ranges == np.inf, reach, 0.0))
    readings = " ".join(f"{reading:.9g}" for reading in ranges.tolist())
    fov = scan.angle_max - scan.angle_min
    return f"0 {scan.angle_min!r} {fov!r} {scan.angle_increment!r} {reach:.7g} 0 0 {len(ranges)} {readings}"


def _pose(pose: Pose2D) -> str:
    return f"{pose.x:.9f} {pose.y:.9f} {pose.theta:.12f}"


def _times(stamp: float) -> str:
    return f"{stamp:.6f} {_HOST} {stamp:.6f}"
