"""MCAP files, written scan by scan, and read up to their end or damage: https://mcap.dev/spec."""

import struct
import zlib
from collections.abc import Generator, Iterator
from contextlib import closing, suppress
from io import BytesIO
from pathlib import Path
from typing import IO, Final, cast

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError, RecordLengthLimitExceeded
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from slam.files.disk import WholeFile
from slam.files.ros.encoder import Encoder
from slam.files.ros.messages import TYPES, RawMessage, ros2_type
from slam.files.unpacking import DamagedChunk, Losses, TooMuch, Unpacker
from slam.limits import CHUNK

_DAMAGE: Final = (McapError, DamagedChunk, struct.error, EOFError, ValueError, KeyError)


class McapWriter:
    """Messages in CDR on the topics of a run, appended to a file in chunks packed with zstd."""

    def __init__(self, path: Path, encoder: Encoder, chunk_size: int) -> None:
        """Begin a new file; a chunk is written as soon as it has ``chunk_size`` bytes."""
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

    def note(self, name: str, values: dict[str, str]) -> None:
        """Append a metadata record."""
        self._writer.add_metadata(name, values)

    def close(self) -> None:
        """Write the index, and sync everything to the disk."""
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
    """Yield the messages of all topics, with one chunk in memory at a time.

    OSError if the file cannot be opened; a damaged chunk is skipped. TruncatedFile after the last message if the file
    is truncated, a chunk was damaged, or it unpacks to more than the limits allow.
    """
    losses, ending = Losses(path, "chunk"), ""
    with path.open("rb") as file:
        try:
            yield from _messages(file, losses)
        except RecordLengthLimitExceeded as error:
            ending = f"it is read no further: {error}; {CHUNK.reason} (see docs/limits.md)"
        except TooMuch as excess:
            ending = f"it is read no further: {excess}"
        except _DAMAGE:
            ending = "the file is damaged or ends early, and what comes after that is lost"
    losses.end(ending)


def mcap_note(path: Path, name: str) -> dict[str, str]:
    """Return the metadata record of this name before the first message.

    Empty if there is none. OSError if the file cannot be opened.
    """
    with path.open("rb") as file, suppress(*_DAMAGE):
        for record in StreamReader(_Whole(file), emit_chunks=True, record_size_limit=CHUNK.most).records:  # type: ignore[arg-type]
            if isinstance(record, Metadata) and record.name == name:
                return dict(record.metadata)
            if isinstance(record, Chunk | Message):
                break
    return {}


def _messages(file: IO[bytes], losses: Losses) -> Iterator[RawMessage]:
    topics, unpacker = _Topics(), Unpacker()
    for record in StreamReader(_Whole(file), emit_chunks=True, record_size_limit=CHUNK.most).records:  # type: ignore[arg-type]
        if not isinstance(record, Chunk):
            yield from topics.message(record)
            continue
        try:
            for inner in _records(_unpacked(record, unpacker)):
                yield from topics.message(inner)
        except _DAMAGE:
            losses.add(f"byte {file.tell() - len(record.data)}")


class _Topics:
    """The channels and schemas read so far."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def message(self, record: McapRecord) -> Iterator[RawMessage]:
        """Yield the message in a record, if it is one; KeyError if its channel or schema is unknown."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        elif isinstance(record, Message):
            channel = self._channels[record.channel_id]
            name = ros2_type(self._schemas[channel.schema_id].name) if channel.schema_id else ""
            yield RawMessage(channel.topic, name, channel.message_encoding, record.data, record.log_time)


def _unpacked(chunk: Chunk, unpacker: Unpacker) -> bytes:
    """Return the unpacked data of a chunk. DamagedChunk for a wrong checksum, KeyError for an unknown compression."""
    data = unpacker.chunk(chunk.compression, chunk.data) if chunk.compression else chunk.data
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise DamagedChunk("its checksum is wrong")
    return data


def _records(chunk: bytes) -> Iterator[McapRecord]:
    """Yield the schemas, channels and messages in the data of a chunk."""
    stream = ReadDataStream(_Whole(BytesIO(chunk)))  # type: ignore[arg-type]
    while stream.count < len(chunk):
        opcode, length = stream.read1(), stream.read8()
        body = ReadDataStream(_Whole(BytesIO(stream.read(length))))  # type: ignore[arg-type]
        if opcode == Opcode.MESSAGE:
            yield Message.read(body, length)
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(body)
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(body)


class _Whole:
    """A file whose reads return all requested bytes; EOFError if it is truncated, or the request is too large."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def read(self, size: int) -> bytes:
        if not 0 <= size <= CHUNK.most:
            raise EOFError
        data = self._file.read(size)
        if len(data) < size:
            raise EOFError
        return data
