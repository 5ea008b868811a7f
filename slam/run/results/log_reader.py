"""``log.mcap`` read back, as far as it was written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from slam.errors import InputError
from slam.files.ros.decoder import Transform, decode_odometry, decode_pose, decode_scan, decode_transforms
from slam.files.ros.mcap_messages import mcap_messages
from slam.files.ros.raw_message import RawMessage
from slam.files.ros.topics import GROUND_TRUTH, ODOM, SCAN, TF, TF_STATIC
from slam.files.text_lines import CutShort
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.robot import Observation


def logged_observations(path: Path) -> Iterator[Observation]:
    """What the robot saw, scan by scan; ranges in single precision. InputError when there is no such file."""
    odometry, truth = Odometry(0.0, Pose2D()), None
    for message in logged_messages(path):
        if message.topic == ODOM:
            odometry = decode_odometry(message).odometry
        elif message.topic == GROUND_TRUTH:
            truth = decode_pose(message).pose
        elif message.topic == SCAN:
            yield Observation(decode_scan(message), odometry, truth)


def logged_mount(path: Path) -> Pose2D:
    """``T_base_laser``; InputError when there is no such file or it ends before that."""
    return _first_transforms(path, TF_STATIC)[0].pose


def logged_start(path: Path) -> Pose2D:
    """``T_map_base`` at the first scan, as estimated; InputError likewise."""
    T_odom_base, T_map_odom = _first_transforms(path, TF)
    return T_map_odom.pose @ T_odom_base.pose


def _first_transforms(path: Path, topic: str) -> list[Transform]:
    for message in logged_messages(path):
        if message.topic == topic:
            return decode_transforms(message)
    raise InputError(f"{path}: holds no scan; the run was ended before its first")


def logged_messages(path: Path) -> Iterator[RawMessage]:
    """All of it, in the order of the file; InputError when there is no such file."""
    try:
        with suppress(CutShort):
            yield from mcap_messages(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; the folder of a run has this file") from error
