"""Folders of ROS 2 bags, sqlite3 and MCAP, as rosbags reads them."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path

from rosbags.rosbag2 import Reader, ReaderError

from slam.errors import LogError
from slam.files.ros.raw_message import RawMessage


def messages(path: Path) -> Iterator[RawMessage]:
    """The messages of all topics; LogError for what rosbags does not read."""
    try:
        with Reader(path) as reader:
            for connection, time, data in reader.messages():
                yield RawMessage(connection.topic, connection.msgtype, "cdr", bytes(data), time)
    except (ReaderError, sqlite3.Error, struct.error, ValueError, LookupError) as error:
        raise LogError(f"{path}: not a ROS 2 bag that can be read: {error}") from error
