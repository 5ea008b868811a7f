"""ROS 1 bags, format 2.0, of ``sensor_msgs/LaserScan``: http://wiki.ros.org/Bags/Format/2.0.

One topic, that of the first such connection. There is no odometry in a scan, so the robot is taken to stand still. The
reader is the project's own: bags of 2010 give a wrong length for their index records, on which rosbags gives up.
"""

from __future__ import annotations

import bz2
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from slam.errors import LogError
from slam.pose import Pose2D
from slam.run.logs.fields import BadLine
from slam.run.logs.laser_scan import BagScan, parse_laser_scan
from slam.run.logs.log import Log, scan_time
from slam.run.logs.stamps import in_order
from slam.run.logs.tally import Tally
from slam.scan import Lidar

MAGIC: Final = b"#ROSBAG V2.0\n"
_TYPE: Final = b"sensor_msgs/LaserScan"
_MESSAGE, _INDEX, _CHUNK, _CONNECTION = 2, 4, 5, 7
_INDEX_ENTRY: Final = 12
"""Bytes: seconds, nanoseconds, offset."""
_Record = tuple[dict[bytes, bytes], bytes]


def recognises(path: Path) -> bool:
    """Whether the file is a ROS 1 bag."""
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def read(path: Path) -> Log:
    """The scans of a bag; LogError when it holds none."""
    tally = Tally(path)
    try:
        scans = _of_one_fan(in_order(list(_scans(path.read_bytes(), tally)), tally), tally)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error
    if not scans:
        raise tally.no_scans("sensor_msgs/LaserScan messages")
    stamps = np.array([scan.stamp for scan in scans])
    fan = scans[0].fan
    return Log(
        lidar=Lidar(fan.angle_min, fan.angle_increment, fan.beams, fan.range_min, fan.range_max, scan_time(stamps)),
        T_base_laser=Pose2D(),
        stamps=stamps,
        ranges=np.stack([scan.ranges for scan in scans]),
        T_odom_base=np.zeros((len(scans), 3)),
        time_increment=fan.time_increment,
        skipped=tally.skipped,
        ignored=tally.ignored,
        report=tally.report(len(scans)),
    )


def _scans(bag: bytes, tally: Tally) -> Iterator[BagScan]:
    """The scans of the first topic that has any; messages are numbered from 1."""
    topics: dict[bytes, bytes] = {}
    topic, number = None, 0
    for header, data in _messages(bag, tally):
        if header[b"op"][0] == _CONNECTION:
            topics[header[b"conn"]] = header[b"topic"] if _fields(data).get(b"type") == _TYPE else b""
            continue
        number += 1
        name = topics.get(header[b"conn"], b"")
        topic = topic or name
        if not name or name != topic:
            tally.ignored["other"] += 1
            continue
        try:
            yield parse_laser_scan(data, number)
        except BadLine as fault:
            tally.skip(str(fault), number)


def _messages(bag: bytes, tally: Tally) -> Iterator[_Record]:
    """The connections and messages of all chunks, as far as the file is whole."""
    try:
        for header, data in _records(bag, len(MAGIC)):
            if header[b"op"][0] == _CHUNK:
                chunk = _unpacked(header[b"compression"], data, tally.path)
                for record in _records(chunk, 0):
                    if record[0][b"op"][0] in (_CONNECTION, _MESSAGE):
                        yield record
    except (struct.error, KeyError, IndexError, ValueError, OSError, EOFError):
        tally.notes.append("the bag is damaged or ends early, and what comes after that is lost")


def _unpacked(compression: bytes, data: bytes, path: Path) -> bytes:
    if compression == b"none":
        return data
    if compression == b"bz2":
        return bz2.decompress(data)
    raise LogError(f"{path}: its chunks are packed with {compression.decode()}; run: rosbag decompress {path.name}")


def _records(data: bytes, at: int) -> Iterator[_Record]:
    """Header fields and data of each record."""
    while at < len(data):
        (size,) = struct.unpack_from("<I", data, at)
        header = _fields(data[at + 4 : at + 4 + size])
        at += 4 + size
        (length,) = struct.unpack_from("<I", data, at)
        if header[b"op"][0] == _INDEX:  # some recorders give a length that is not true
            length = _INDEX_ENTRY * struct.unpack("<I", header[b"count"])[0]
        if at + 4 + length > len(data):
            raise EOFError
        yield header, data[at + 4 : at + 4 + length]
        at += 4 + length


def _fields(header: bytes) -> dict[bytes, bytes]:
    """``name=value`` fields, each after its length."""
    fields, at = {}, 0
    while at < len(header):
        (size,) = struct.unpack_from("<I", header, at)
        name, _, value = header[at + 4 : at + 4 + size].partition(b"=")
        fields[name] = value
        at += 4 + size
    return fields


def _of_one_fan(scans: list[BagScan], tally: Tally) -> list[BagScan]:
    """The scans with the fan of the first; the others are skipped."""
    for scan in scans:
        if scan.fan != scans[0].fan:
            tally.skip("changed fan", scan.line)
    return [scan for scan in scans if scan.fan == scans[0].fan]
