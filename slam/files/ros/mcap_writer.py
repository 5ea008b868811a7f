"""MCAP files that grow: https://mcap.dev/spec. What is cut off can be read up to the last whole chunk."""

from __future__ import annotations

import os
from pathlib import Path

from mcap.writer import Writer

from slam.files.ros.encoder import Encoder
from slam.files.ros.topics import TYPES


class McapWriter:
    """Messages in CDR on the topics of a run, appended to a file in chunks packed with zstd."""

    def __init__(self, path: Path, encoder: Encoder, chunk_size: int) -> None:
        """A new file, whose chunks go to the system as soon as they hold ``chunk_size`` bytes."""
        self._encoder = encoder
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=chunk_size)
        self._writer.start(profile="ros2", library="hopslam")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def write(self, topic: str, nanoseconds: int, message: bytes) -> None:
        """Append a message, logged and published at that time."""
        channel = self._channels.get(topic) or self._open(topic)
        self._writer.add_message(channel, nanoseconds, message, nanoseconds)

    def flush(self) -> None:
        """Hand whole chunks to the system."""
        self._file.flush()

    def close(self) -> None:
        """Write the index, and put everything on the disk."""
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap types most, not all
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def _open(self, topic: str) -> int:
        name = TYPES[topic]
        if name not in self._schemas:
            definition = self._encoder.definition(name).encode()
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", definition)
        self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        return self._channels[topic]
