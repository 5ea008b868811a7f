"""Kind of bag at a path, and the reader of its messages, imported when there is one."""

import sqlite3
import struct
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final

from slam.errors import LogError
from slam.files.logs import rosbag1
from slam.files.ros.messages import RawMessage

Messages = Callable[[Path], Iterable[RawMessage]]
_MCAP: Final = b"\x89MCAP0\r\n"
RUN_LOG: Final = "log.mcap"
"""Name of the log in the folder of a run."""


def bag_reader(path: Path) -> Messages | None:
    """The reader of the messages of the bag at a path; None where there is no bag."""
    if path.is_dir():
        return _folder(path)
    try:
        with path.open("rb") as file:
            head = file.read(len(rosbag1.MAGIC))
    except OSError:
        return None
    if head == rosbag1.MAGIC:
        return rosbag1.messages
    return _mcap() if head.startswith(_MCAP) else None


def _folder(path: Path) -> Messages | None:
    """Reader of a run's log in its folder, of a ROS 2 bag where there is metadata, or of the only MCAP file in it."""
    if (path / "metadata.yaml").is_file():
        return _rosbag2
    files = [path / RUN_LOG] if (path / RUN_LOG).is_file() else list(path.glob("*.mcap"))
    if len(files) != 1:
        return None
    messages = _mcap()
    return lambda _: messages(files[0])


def _mcap() -> Messages:
    from slam.files.ros.mcap_files import mcap_messages

    return mcap_messages


def _rosbag2(path: Path) -> Iterator[RawMessage]:
    """Messages of all topics of a ROS 2 bag, sqlite3 or MCAP; LogError for what rosbags does not read."""
    from rosbags.rosbag2 import Reader, ReaderError

    try:
        with Reader(path) as reader:
            for connection, time, data in reader.messages():
                yield RawMessage(connection.topic, connection.msgtype, "cdr", bytes(data), time)
    except (ReaderError, sqlite3.Error, struct.error, ValueError, LookupError) as error:
        raise LogError(f"{path}: not a ROS 2 bag that can be read: {error}") from error
