"""ROS 1 bags, format 2.0: http://wiki.ros.org/Bags/Format/2.0.

The reader of the container is the project's own: bags of 2010 give a wrong length for their index records, on which
rosbags gives up, and a bag that was cut has no index at all.
"""

import bz2
import struct
from collections.abc import Iterator
from pathlib import Path
from shlex import quote
from typing import Final

import lz4.frame

from slam.errors import LogError
from slam.files.ros.messages import RawMessage, ros2_type
from slam.files.text_lines import TruncatedFile

MAGIC: Final = b"#ROSBAG V2.0\n"
_MESSAGE, _INDEX, _CHUNK, _CONNECTION = 2, 4, 5, 7
_INDEX_ENTRY: Final = 12
"""Bytes: seconds, nanoseconds, offset."""
_Record = tuple[dict[bytes, bytes], bytes]


def messages(path: Path) -> Iterator[RawMessage]:
    """The messages of all topics; TruncatedFile after the last one of a bag that is cut or damaged."""
    connections: dict[bytes, tuple[str, str]] = {}
    try:
        for header, data in _in_chunks(path.read_bytes(), path):
            if header[b"op"][0] == _CONNECTION:
                name = ros2_type(_fields(data).get(b"type", b"").decode())
                connections[header[b"conn"]] = header[b"topic"].decode(), name
            else:
                topic, name = connections.get(header[b"conn"], ("", ""))
                seconds, rest = struct.unpack("<II", header[b"time"])
                yield RawMessage(topic, name, "ros1", data, 10**9 * seconds + rest)
    except (struct.error, KeyError, IndexError, ValueError, EOFError, RuntimeError) as error:
        raise TruncatedFile(f"{path}: the bag is damaged or ends early") from error


def _in_chunks(bag: bytes, path: Path) -> Iterator[_Record]:
    """The connections and messages of all chunks."""
    for header, data in _records(bag, len(MAGIC)):
        if header[b"op"][0] == _CHUNK:
            for record in _records(_unpacked(header[b"compression"], data, path), 0):
                if record[0][b"op"][0] in (_CONNECTION, _MESSAGE):
                    yield record


def _unpacked(compression: bytes, data: bytes, path: Path) -> bytes:
    try:
        if compression == b"none":
            return data
        if compression == b"bz2":
            return bz2.decompress(data)
        if compression == b"lz4":
            return bytes(lz4.frame.decompress(data))
    except OSError as error:  # of bz2, for damaged data
        raise EOFError from error
    raise LogError(
        f"{path}: its chunks are packed with {compression.decode()}; run: rosbag decompress {quote(str(path))}"
    )


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
