"""ROS 1 bags, format 2.0: http://wiki.ros.org/Bags/Format/2.0.

The reader of the container is the project's own: bags of 2010 have a wrong length of their index records, which rosbags
rejects, and a truncated bag has no index.
"""

import io
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from shlex import quote
from typing import IO, Final

from slam.errors import LogError
from slam.files.ros.messages import RawMessage, ros2_type
from slam.files.unpacking import DamagedChunk, Losses, TooMuch, Unpacker
from slam.limits import CHUNK

MAGIC: Final = b"#ROSBAG V2.0\n"
_MESSAGE, _INDEX, _CHUNK, _CONNECTION = 2, 4, 5, 7
_INDEX_ENTRY: Final = 12
"""Index entry, bytes: seconds, nanoseconds, offset."""
_PACKINGS: Final = {b"none": "", b"bz2": "bz2", b"lz4": "lz4"}
_DAMAGE: Final = (DamagedChunk, struct.error, KeyError, IndexError, ValueError, EOFError)
_Header = dict[bytes, bytes]
_Connections = dict[bytes, tuple[str, str]]


def messages(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of all topics, with one chunk in memory at a time.

    A damaged chunk is skipped; TruncatedFile after the last message if the bag is truncated, had such a chunk, or
    unpacks to more than the limits allow.
    """
    losses, ending = Losses(path, "chunk"), ""
    with path.open("rb") as file:
        try:
            yield from _in_chunks(file, path, losses)
        except _DAMAGE:
            ending = "the bag is damaged or ends early, and what comes after that is lost"
        except TooMuch as excess:
            ending = f"the bag is read no further: {excess}"
    losses.end(ending)


def _in_chunks(file: IO[bytes], path: Path, losses: Losses) -> Iterator[RawMessage]:
    connections: _Connections = {}
    unpacker = Unpacker()
    file.seek(len(MAGIC))
    for header, data in _records(file, {_CHUNK}, cut=True):
        at = file.tell() - len(data)
        try:
            if header[b"compression"] not in _PACKINGS and not connections:
                raise LogError(_unknown_packing(header[b"compression"], path))
            yield from _messages(_unpacked(header[b"compression"], data, unpacker), connections)
        except _DAMAGE:
            losses.add(f"byte {at}")


def _messages(chunk: bytes, connections: _Connections) -> Iterator[RawMessage]:
    """Yield the messages of a chunk; its connections are added to the known ones."""
    for header, data in _records(io.BytesIO(chunk), {_CONNECTION, _MESSAGE}):
        if header[b"op"][0] == _CONNECTION:
            name = ros2_type(_fields(data).get(b"type", b"").decode())
            connections[header[b"conn"]] = header[b"topic"].decode(), name
        else:
            topic, name = connections.get(header[b"conn"], ("", ""))
            seconds, rest = struct.unpack("<II", header[b"time"])
            yield RawMessage(topic, name, "ros1", data, 10**9 * seconds + rest)


def _unpacked(compression: bytes, data: bytes, unpacker: Unpacker) -> bytes:
    return data if compression == b"none" else unpacker.chunk(_PACKINGS[compression], data)


def _unknown_packing(compression: bytes, path: Path) -> str:
    packing = compression.decode(errors="replace")
    return f"{path}: its chunks are packed with {packing}; run: rosbag decompress {quote(str(path))}"


def _records(file: IO[bytes], wanted: set[int], cut: bool = False) -> Iterator[tuple[_Header, bytes]]:
    """Yield header fields and data of each record of the wanted kinds.

    EOFError for a truncated last record; with ``cut``, the part of its data that is there is yielded first.
    """
    at = file.tell()
    end = file.seek(0, os.SEEK_END)
    while at < end:
        file.seek(at)
        header = _fields(_sized(file, end))
        kind, (length,) = header[b"op"][0], struct.unpack("<I", _exactly(file, 4))
        if kind == _INDEX:  # some recorders write a wrong length
            length = _INDEX_ENTRY * struct.unpack("<I", header[b"count"])[0]
        at = file.tell() + length
        if kind in wanted and (cut or at <= end):
            yield header, _exactly(file, min(length, end - file.tell()))
        if at > end:
            raise EOFError


def _sized(file: IO[bytes], end: int) -> bytes:
    """Read a length and that number of bytes."""
    (length,) = struct.unpack("<I", _exactly(file, 4))
    if file.tell() + length > end:
        raise EOFError
    return _exactly(file, length)


def _exactly(file: IO[bytes], size: int) -> bytes:
    if excess := CHUNK.excess(size, "in one record"):
        raise TooMuch(excess)
    data = file.read(size)
    if len(data) < size:
        raise EOFError
    return data


def _fields(header: bytes) -> _Header:
    """Parse ``name=value`` fields, each after its length."""
    fields, at = {}, 0
    while at < len(header):
        (size,) = struct.unpack_from("<I", header, at)
        name, _, value = header[at + 4 : at + 4 + size].partition(b"=")
        fields[name] = value
        at += 4 + size
    return fields
