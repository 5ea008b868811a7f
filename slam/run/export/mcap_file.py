"""The log of a run as an MCAP file with its index, also where the run was cut off."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from slam.files.ros.encoder import Encoder
from slam.files.ros.mcap_files import McapWriter
from slam.files.whole_files import whole_file
from slam.run.results.run_log import LOG, logged_messages
from slam.run.results.run_record import RunRecord

_CHUNK: Final = 1 << 20
"""Bytes, as recorders have it."""


def write(record: RunRecord, out: Path) -> None:
    """The topics of ``log.mcap``, message by message."""
    with whole_file(out) as draft:
        writer = McapWriter(draft, Encoder(), _CHUNK)
        for message in logged_messages(record.folder / LOG):
            writer.write(message.topic, message.time, message.data)
        writer.close()
