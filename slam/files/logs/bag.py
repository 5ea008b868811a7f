"""Bags of ROS 1 and ROS 2, and MCAP files: scans of one lidar, with the odometry that came along.

Odometry is that of ``nav_msgs/Odometry``, or else the transforms from ``odom`` to the base; the mount of the lidar
comes from the transforms. A log of this project says besides where in the map it began, and what was true.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.files.logs.bag_contents import BagContents, BagScan, parse_laser_scan
from slam.files.logs.bag_poses import FrameTree, PoseSeries
from slam.files.logs.log import BagTopics, Log, scan_time
from slam.files.logs.outliers import drop_outliers
from slam.files.logs.read_statistics import ReadStatistics, drop_out_of_order
from slam.files.ros.decoder import StampedOdometry, Transform, decode_odometry, decode_pose
from slam.files.ros.messages import LASER_SCAN, ODOMETRY, POSE, RawMessage
from slam.pose import FloatArray, Pose2D, relative_poses

_BASES: Final = ("base_link", "base_footprint")


def read(path: Path, messages: Iterable[RawMessage], topics: BagTopics) -> Log:
    """The log in these messages; LogError when it holds no scan, or more topics than one and none is chosen."""
    statistics = ReadStatistics(path)
    try:
        contents = BagContents.read(messages, statistics)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error
    scans = _scans(contents, topics.scan)
    if not scans:
        raise statistics.no_scans("sensor_msgs/LaserScan messages")
    return _log(contents, scans, topics.odometry)


def _scans(contents: BagContents, topic: str | None) -> list[BagScan]:
    """The scans with the fan of the first, in order; the others are skipped."""
    statistics, scans = contents.statistics, []
    for number, raw in contents.messages_of(LASER_SCAN, topic, "--scan-topic"):
        try:
            scans.append(parse_laser_scan(raw, number))
        except BadLine as fault:
            statistics.skip(str(fault), number)
    scans = drop_out_of_order(scans, statistics)
    for scan in scans:
        if scan.fan != scans[0].fan:
            statistics.skip("changed fan", scan.line)
    return [scan for scan in scans if scan.fan == scans[0].fan]


def _log(contents: BagContents, scans: list[BagScan], odometry_topic: str | None) -> Log:
    statistics = contents.statistics
    stamps = np.array([scan.stamp for scan in scans])
    static, moving = contents.transforms(static=True), contents.transforms(static=False)
    track, base = _odometry(contents, odometry_topic, moving)
    T_odom_base = np.zeros((len(scans), 3)) if track is None else track.poses_at(stamps)
    if track is None:
        statistics.notes.append("no odometry in it")
    elif not track.covers(stamps):
        statistics.notes.append("its odometry does not cover the time of its scans")
    return Log(
        lidar=replace(scans[0].fan, scan_time=scan_time(stamps)),
        T_base_laser=_mount(FrameTree([*static, *moving]), base, scans[0].frame, statistics, track is not None),
        stamps=stamps,
        ranges=np.stack([scan.ranges for scan in scans]),
        T_odom_base=relative_poses(T_odom_base[0], T_odom_base),
        time_increment=float(np.median([scan.time_increment for scan in scans])),
        skipped=statistics.skipped,
        ignored=statistics.ignored,
        report=statistics.report(len(scans)),
        has_odometry=track is not None,
        twists=None if track is None else track.twists_at(stamps),
        start=_start(moving, Pose2D.from_array(T_odom_base[0])),
        T_map_base=_truth(contents, stamps),
    )


def _odometry(contents: BagContents, topic: str | None, moving: list[Transform]) -> tuple[PoseSeries | None, str]:
    """Motion of the base in the frame of its odometry, None where that is not known; and the name of the base."""
    messages = _without_outliers(
        contents.decoded(contents.messages_of(ODOMETRY, topic, "--odom-topic"), decode_odometry), contents.statistics
    )
    if messages:
        return PoseSeries.of_odometry([message.odometry for message in messages]), messages[0].child or _BASES[0]
    links = [t for t in moving if t.frame.rpartition("/")[2] == "odom" and t.child.rpartition("/")[2] in _BASES]
    if links:
        base = links[0].child
        return PoseSeries.of_poses([(t.stamp, t.pose) for t in links if t.child == base]), base
    return None, _BASES[0]


def _without_outliers(messages: Iterable[StampedOdometry], statistics: ReadStatistics) -> list[StampedOdometry]:
    """The messages without those whose pose is an outlier, which are counted by their number on the topic."""
    numbered = list(enumerate(messages, 1))
    kept = drop_outliers(
        numbered, lambda one: _position(one[1]), lambda one: statistics.skip("outlying pose", one[0]), statistics.notes
    )
    return [message for _, message in kept]


def _position(message: StampedOdometry) -> tuple[float, float, float]:
    odometry = message.odometry
    return odometry.stamp, odometry.T_odom_base.x, odometry.T_odom_base.y


def _mount(tree: FrameTree, base: str, laser: str, statistics: ReadStatistics, moves: bool) -> Pose2D:
    """``T_base_laser``; where nothing tells it, the laser is taken to sit on the centre."""
    try:
        mount = tree.mount(base, laser)
    except LogError as error:
        raise LogError(f"{statistics.path}: {error}") from None
    if mount is None and moves:
        statistics.notes.append(f"no transform from {base} to {laser}, so the laser is taken to sit on its centre")
    return mount or Pose2D()


def _start(moving: list[Transform], first: Pose2D) -> Pose2D:
    """``T_map_base`` at the first scan, where a map is known; identity otherwise."""
    starts = (link.pose @ first for link in moving if (link.frame, link.child) == ("map", "odom"))
    return next(starts, Pose2D())


def _truth(contents: BagContents, stamps: FloatArray) -> FloatArray | None:
    """``T_map_base`` as it was, (N, 3), where the bag has it."""
    messages = contents.decoded(contents.messages_of(POSE, None, "topic"), decode_pose)
    poses = [(message.stamp, message.pose) for message in messages if message.frame == "map"]
    if not poses or not (track := PoseSeries.of_poses(poses)).covers(stamps):
        return None
    return track.poses_at(stamps)
