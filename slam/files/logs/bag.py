"""Bags of ROS 1 and ROS 2, and MCAP files: scans of one lidar, with odometry.

Odometry is that of ``nav_msgs/Odometry``, or else the transforms from ``odom`` to the base; the mount of the lidar
comes from the transforms. A log of this project also has its start pose in the map, and true poses.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from slam.errors import LogError
from slam.files.logs.bag_contents import BagContents
from slam.files.logs.bag_odometry import BagOdometry
from slam.files.logs.bag_poses import BASES, FrameTree, Mount, PoseSeries, is_odometry
from slam.files.logs.bag_scans import BagScan, ranges_of, scans_of_one_lidar
from slam.files.logs.log import BagTopics, Log, lidar_of, scan_time
from slam.files.logs.outliers import drop_outliers
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.logs.stamps import drop_repeats, scan_times
from slam.files.logs.streamed_ranges import StreamedRanges
from slam.files.ros.decimals import rounded_pose
from slam.files.ros.decoder import StampedOdometry, Transform
from slam.files.ros.messages import LASER_SCAN, MULTI_ECHO, ODOMETRY, POSE, RawMessage
from slam.odometry import Odometry
from slam.pose import FloatArray, Pose2D, relative_poses

Reader = Callable[[Path], Iterator[RawMessage]]


def read(path: Path, messages: Reader, topics: BagTopics) -> Log:
    """Read the log in the messages at a path; LogError if it has no scan, or not the requested topic.

    The file is read twice: now all but the ranges, and the ranges later, on request.
    """
    statistics, place = ReadStatistics(path, "message"), path.resolve()
    try:
        contents = BagContents.read(messages(path), statistics)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error
    scans = drop_repeats(_scans(contents, topics.scan), statistics)
    if not scans:
        raise statistics.no_scans("sensor_msgs/LaserScan messages")
    return _log(contents, scans, topics.odometry, lambda: enumerate(messages(place), 1))


def _scans(contents: BagContents, topic: str | None) -> list[BagScan]:
    """Return the scans of one topic, and of one lidar on it."""
    found = contents.messages_of(topic, "--scan-topic", LASER_SCAN, MULTI_ECHO)
    scans = scans_of_one_lidar(list(contents.values(found, scans=True)), contents.statistics)
    if any(found is messages for messages in contents.by_type.get(MULTI_ECHO, {}).values()):
        contents.statistics.notes.append("of each beam of its MultiEchoLaserScan messages, the first echo is read")
    return scans


def _log(
    contents: BagContents, scans: list[BagScan], odometry_topic: str | None,
    again: Callable[[], Iterator[tuple[int, RawMessage]]],
) -> Log:  # fmt: skip
    """Make the log of these scans; their ranges are read from the numbered messages in another pass."""
    statistics = contents.statistics
    static, moving = contents.transforms(static=True), contents.transforms(static=False)
    odometry = _odometry(contents, odometry_topic, moving)
    mount = _mount(FrameTree([*static, *moving]), odometry.base, scans[0].frame, statistics, bool(odometry.messages))
    upright = [scan.upright(mount.inverted) for scan in scans]
    scans, fans = [scan for scan, _ in upright], [fan for _, fan in upright]
    stamps, clock = scan_times(
        np.array([scan.stamp for scan in scans]), np.array([scan.received for scan in scans]),
        [scan.line for scan in scans], statistics,
    )  # fmt: skip
    track = odometry.track(clock, stamps, statistics)
    T_odom_base = np.zeros((len(scans), 3)) if track is None else track.poses_at(stamps)
    between = [scan.time_increment for scan in scans]
    places, turned = np.array([scan.line for scan in scans]), np.array([scan.turned for scan in scans])
    lidar, table = lidar_of(fans, between)
    if table is not None:
        statistics.notes.append(table.note)
    return Log(
        lidar=replace(lidar, scan_time=scan_time(stamps)),
        T_base_laser=mount.T_base_laser,
        stamps=stamps,
        ranges=StreamedRanges(
            statistics.path, lambda: ranges_of(again(), places, turned), [scan.beams for scan in scans]
        ),
        T_odom_base=relative_poses(T_odom_base[0], T_odom_base),
        time_increment=float(np.median(between)),
        skipped=statistics.skipped,
        ignored=statistics.ignored,
        report=statistics.report(len(scans)),
        has_odometry=track is not None,
        twists=None if track is None else track.twists_at(stamps),
        start=_start(moving, Pose2D.from_array(T_odom_base[0])),
        T_map_base=_truth(contents, stamps),
        fans=table,
        lost=statistics.lost,
    )


def _odometry(contents: BagContents, topic: str | None, moving: list[Transform]) -> BagOdometry:
    """Return the odometry in the messages of a topic, or else in the transforms; empty if there is none."""
    found = contents.messages_of(topic, "--odom-topic", ODOMETRY)
    if messages := _without_outliers(contents.values(found), contents.statistics):
        return BagOdometry.of(messages, messages[0].child or BASES[0])
    links = [t for t in moving if is_odometry(t)]
    base = links[0].child if links else BASES[0]
    poses = (StampedOdometry(Odometry(t.stamp, t.pose), base, t.received) for t in links if t.child == base)
    return BagOdometry.of(_without_outliers(poses, contents.statistics), base)


def _without_outliers(messages: Iterable[StampedOdometry], statistics: ReadStatistics) -> list[StampedOdometry]:
    """Return the messages without those of outlying poses, which are reported by their numbers on the topic."""

    def skip(one: tuple[int, StampedOdometry]) -> None:
        statistics.skip("outlying pose", one[0], scan=False)

    numbered = list(enumerate(messages, 1))
    return [message for _, message in drop_outliers(numbered, lambda one: _position(one[1]), skip, statistics.notes)]


def _position(message: StampedOdometry) -> tuple[float, float, float]:
    odometry = message.odometry
    return odometry.stamp, odometry.T_odom_base.x, odometry.T_odom_base.y


def _mount(tree: FrameTree, base: str, laser: str, statistics: ReadStatistics, moves: bool) -> Mount:
    """Return the mount of the lidar on the base of the odometry, or on another known base of the robot.

    If the bag does not contain it, the laser is assumed at the centre.
    """
    try:
        mount = tree.mount(base, laser)
    except LogError as error:
        raise LogError(f"{statistics.path}: {error}") from None
    if mount is None and moves:
        statistics.notes.append(f"no transform from {base} to {laser}, so the laser is taken to sit on its centre")
    if mount is not None and mount.inverted:
        statistics.notes.append(f"{laser} hangs upside down, so its beams are mirrored")
    return mount or Mount(Pose2D())


def _start(moving: list[Transform], first: Pose2D) -> Pose2D:
    """Return ``T_map_base`` at the first scan, if a map is known; identity otherwise."""
    starts = (rounded_pose(link.pose @ first) for link in moving if (link.frame, link.child) == ("map", "odom"))
    return next(starts, Pose2D())


def _truth(contents: BagContents, stamps: FloatArray) -> FloatArray | None:
    """Return the true ``T_map_base``, (N, 3), if the bag has it."""
    messages = contents.values(contents.messages_of(None, "topic", POSE))
    poses = [(message.stamp, message.pose) for message in messages if message.frame == "map"]
    if not poses or not (track := PoseSeries.of_poses(poses)).covers(stamps):
        return None
    return track.poses_at(stamps)
