"""The messages of an MCAP file in the order of the file, to its end or to where it was cut."""

from __future__ import annotations

import struct
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Final

from mcap.exceptions import McapError
from mcap.records import Channel, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from slam.files.ros.raw_message import RawMessage, ros2_type
from slam.files.text_lines import CutShort

_LARGEST_RECORD: Final = 1 << 30
_DAMAGE: Final = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, RuntimeError, MemoryError)


def mcap_messages(path: Path) -> Generator[RawMessage]:
    """The messages of all topics. OSError where the file cannot be opened; CutShort after the last message of one that
    is cut or damaged."""
    with path.open("rb") as file:
        try:
            yield from _messages(StreamReader(file, record_size_limit=_LARGEST_RECORD).records)
        except _DAMAGE as error:
            raise CutShort(f"{path}: the file is damaged or ends early") from error


def _messages(records: Iterator[McapRecord]) -> Iterator[RawMessage]:
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for record in records:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            channel = channels[record.channel_id]
            name = ros2_type(schemas[channel.schema_id].name) if channel.schema_id else ""
            yield RawMessage(channel.topic, name, channel.message_encoding, record.data, record.log_time)
