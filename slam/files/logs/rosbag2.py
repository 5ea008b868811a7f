"""Bags of ROS 2: a folder of sqlite3 or MCAP files, whole or packed with zstd, with or without its metadata.yaml.

The reader is the project's own: that of rosbags unpacks without a limit, and fails at one damaged message.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final
from urllib.parse import quote

from slam.errors import LogError, ScenarioError
from slam.files.ros.mcap_files import mcap_messages
from slam.files.ros.messages import RawMessage
from slam.files.unpacking import DamagedChunk, Losses, TooMuch, TruncatedFile, Unpacker
from slam.limits import CHUNK
from slam.scenario.yaml_file import YamlFile

METADATA: Final = "metadata.yaml"
_ENDINGS: Final = (".db3", ".mcap", ".db3.zstd", ".mcap.zstd")
_SQLITE: Final = b"SQLite format 3\0"
_MCAP: Final = b"\x89MCAP0\r\n"
_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_QUERY: Final = """
    SELECT topics.name, topics.type, topics.serialization_format, messages.data, messages.timestamp
    FROM messages JOIN topics ON topics.id = messages.topic_id ORDER BY messages.rowid"""
_TABLES: Final = """
    SELECT count(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 AND name IN ('messages', 'topics')"""


def is_bag(folder: Path) -> bool:
    """Return True for the folder of a bag that has its metadata, or the files of one recording."""
    recordings = {re.sub(r"(_[0-9]+)?\..*", "", path.name) for path in _recorded(folder)}
    return (folder / METADATA).is_file() or len(recordings) == 1


def messages(folder: Path) -> Iterator[RawMessage]:
    """Yield the messages of all topics, file after file.

    LogError if there is no file of a bag; TruncatedFile after the last message if a file is damaged, truncated, or
    unpacks to more than the limits allow.
    """
    notes = [] if (folder / METADATA).is_file() else [f"it has no {METADATA}; was its recorder killed?"]
    for path in _files(folder):
        try:
            yield from file_messages(path)
        except TruncatedFile as cut:
            notes.append(f"{path.name}: {cut.note}")
    if notes:
        raise TruncatedFile(folder, "; ".join(notes))


def file_messages(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of one file of a bag, and unpack them if they are packed one by one.

    Raises TruncatedFile as ``messages`` does.
    """
    raws = _of_file(path)
    if (first := next(raws, None)) is not None:
        whole = chain([first], raws)
        yield from _unpacked_messages(whole, path) if first.data.startswith(_ZSTD) else whole


def _files(folder: Path) -> list[Path]:
    """Return the files that the metadata names, and further ones in the folder, in the order of the recording."""
    said = _metadata(folder)
    names = said.get("relative_file_paths")
    named = [folder / Path(name).name for name in names if isinstance(name, str)] if isinstance(names, list) else []
    files = [path for path in named if path.is_file()] or _recorded(folder)
    if not files:
        raise LogError(f"{folder}: not a ROS 2 bag that can be read: it has no file {', '.join(_ENDINGS[:2])}")
    return files


def _metadata(folder: Path) -> dict[str, Any]:
    """Return the contents of the metadata; empty without any."""
    if not (folder / METADATA).is_file():
        return {}
    try:
        said = YamlFile(folder / METADATA).data.get("rosbag2_bagfile_information")
    except ScenarioError as error:
        raise LogError(f"{error}; remove the file, and the bag is read without it") from error
    return said if isinstance(said, dict) else {}


def _recorded(folder: Path) -> list[Path]:
    """Sort the files of a recorder by the numbers in their names."""
    found = [path for path in folder.iterdir() if path.name.endswith(_ENDINGS) and path.is_file()]
    return sorted(found, key=lambda path: [int(part) if part.isdigit() else part for part in _parts(path.name)])


def _parts(name: str) -> list[str]:
    """Split the name into text, number, text, number ..."""
    return re.split(r"([0-9]{1,9})", name)


def _of_file(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of a file; its first bytes show its kind."""
    with path.open("rb") as file:
        head = file.read(len(_SQLITE))
    if head.startswith(_ZSTD):
        yield from _of_packed_file(path)
    elif head.startswith(_MCAP):
        yield from mcap_messages(path)
    elif head == _SQLITE:
        yield from _of_database(path)
    else:
        raise TruncatedFile(path, f"begins with {head!r}, and is neither an sqlite3 nor an MCAP file")


def _of_packed_file(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of a file that was packed as a whole: it is unpacked to a temporary one."""
    ending = ""
    with TemporaryDirectory(prefix="hopslam-bag-") as name:
        unpacked = Path(name) / path.stem
        with path.open("rb") as packed, unpacked.open("wb") as file:
            try:
                file.writelines(Unpacker().blocks("zstd", packed))
            except DamagedChunk:
                ending = "the zstd data are damaged or end early, and what comes after that is lost"
            except TooMuch as excess:
                ending = f"it is read no further: {excess}"
        with unpacked.open("rb") as file:
            nested = file.read(len(_ZSTD)) == _ZSTD
        try:
            yield from () if nested else _of_file(unpacked)
        except TruncatedFile as cut:
            ending = ending or cut.note
    Losses(path, "file", int(nested), "its start").end(ending)


def _of_database(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of a sqlite3 file in the order in which they were written, as far as it is intact."""
    try:
        with closing(sqlite3.connect(f"file:{quote(str(path))}?immutable=1", uri=True)) as database:
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, CHUNK.most)
            database.text_factory = lambda text: text.decode(errors="replace")
            database.execute("PRAGMA trusted_schema = OFF")
            if database.execute(_TABLES).fetchone() != (2,):
                raise TruncatedFile(path, "has no tables messages and topics")
            for topic, kind, encoding, data, time in database.execute(_QUERY):
                if isinstance(data, bytes) and isinstance(time, int):
                    yield RawMessage(str(topic), str(kind), str(encoding), data, time)
    except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter if its message quotes damaged names
        raise TruncatedFile(path, f"the database is damaged, and what comes after that is lost ({error})") from error


def _unpacked_messages(raws: Iterator[RawMessage], path: Path) -> Iterator[RawMessage]:
    """Unpack messages that are packed one by one with zstd."""
    losses, unpacker, ending = Losses(path, "message"), Unpacker(), ""
    try:
        for number, raw in enumerate(raws, 1):
            try:
                yield raw._replace(data=unpacker.chunk("zstd", raw.data))
            except DamagedChunk:
                losses.add(f"message {number}")
    except TooMuch as excess:
        ending = f"it is read no further: {excess}"
    except TruncatedFile as cut:
        ending = cut.note
    losses.end(ending)
