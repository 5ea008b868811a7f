"""The messages of an MCAP file in the order of the file, to its end or to where it was cut."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from mcap.exceptions import McapError
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from zstandard import ZstdError


class RawMessage(NamedTuple):
    """One message, not yet decoded."""

    topic: str
    type: str
    """Such as ``sensor_msgs/msg/LaserScan``."""
    encoding: str
    """``cdr`` or ``ros1``."""
    data: bytes


def mcap_messages(path: Path) -> Iterator[RawMessage]:
    """The messages of all topics; what comes after a cut or a damage is lost. OSError where it cannot be opened."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    damage = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, RuntimeError)
    with path.open("rb") as file, suppress(*damage):
        for record in StreamReader(file, record_size_limit=2**30).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas.get(channel.schema_id)
                yield RawMessage(channel.topic, schema.name if schema else "", channel.message_encoding, record.data)
