"""MCAP files, written as they grow and read to their end or to where they were cut: https://mcap.dev/spec."""

import struct
from collections.abc import Generator, Iterator
from contextlib import closing
from pathlib import Path
from typing import IO, Final, cast

from mcap.exceptions import McapError
from mcap.records import Channel, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from zstandard import ZstdError

from slam.files.disk import WholeFile
from slam.files.ros.encoder import Encoder
from slam.files.ros.messages import TYPES, RawMessage, ros2_type
from slam.files.text_lines import TruncatedFile

_LARGEST_RECORD: Final = 1 << 30
_DAMAGE: Final = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, RuntimeError, MemoryError)


class McapWriter:
    """Messages in CDR on the topics of a run, appended to a file in chunks packed with zstd."""

    def __init__(self, path: Path, encoder: Encoder, chunk_size: int) -> None:
        """A new file, whose chunks go to the system as soon as they hold ``chunk_size`` bytes."""
        self._encoder = encoder
        self._file = WholeFile(path)
        self._writer = Writer(cast("IO[bytes]", self._file), chunk_size=chunk_size)
        self._writer.start(profile="ros2", library="hopslam")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def write(self, topic: str, nanoseconds: int, message: bytes) -> None:
        """Append a message, logged and published at that time."""
        channel = self._channels.get(topic) or self._open(topic)
        self._writer.add_message(channel, nanoseconds, message, nanoseconds)

    def close(self) -> None:
        """Write the index, and put everything on the disk."""
        with closing(self._file):
            self._writer.finish()  # type: ignore[no-untyped-call]  # mcap types most, not all

    def _open(self, topic: str) -> int:
        name = TYPES[topic]
        if name not in self._schemas:
            definition = self._encoder.definition(name).encode()
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", definition)
        self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        return self._channels[topic]


def mcap_messages(path: Path) -> Generator[RawMessage]:
    """The messages of all topics. OSError where the file cannot be opened; TruncatedFile after the last message of one
    that is cut or damaged."""
    with path.open("rb") as file:
        try:
            yield from _messages(StreamReader(file, record_size_limit=_LARGEST_RECORD).records)
        except _DAMAGE as error:
            raise TruncatedFile(f"{path}: the file is damaged or ends early") from error


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
