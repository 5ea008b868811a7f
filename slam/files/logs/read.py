"""Reads a recorded log whose format is recognised from its content; modules for bags are imported only for bags."""

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from itertools import chain, islice
from pathlib import Path
from typing import Final

from slam.errors import LogError
from slam.files.logs import carmen, foreign, rosbag1, urg_text
from slam.files.logs.log import BagTopics, Log
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.ros.messages import RawMessage
from slam.files.text_lines import read_lines
from slam.files.unpacking import TruncatedFile

RUN_LOG: Final = "log.mcap"
"""Name of the log in the folder of a run."""
_SQLITE: Final = b"SQLite"
_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_MCAP: Final = b"\x89MCAP0\r\n"
_NEED: Final = (
    "CARMEN messages, CMU L lines, URG-04LX text of 707 columns, plain or gzip, a ROS bag, MCAP, or a run folder"
)
_HEAD: Final = 200
"""Number of first lines in which the format must show."""
_FORMATS: Final = ((carmen.recognises, carmen.read), (urg_text.recognises, urg_text.read))
"""A test for a line that can only be of this format, and the reader of the numbered lines."""


def read_log(path: str | Path, topics: BagTopics | None = None) -> Log:
    """Read the recorded run at a path.

    It is a file of CARMEN messages, of CMU's L and O lines, or the text of a URG-04LX with wheel encoders, plain or
    gzip; the laser scans and the odometry of a ROS 1 bag, of a folder of a ROS 2 bag, or of an MCAP file; or the folder
    of a run.

    Unusable lines are skipped and counted in ``Log.report``. Raises LogError, of one line, if the file cannot be read,
    is not such a log, has no scan, or has several topics and ``topics`` chooses none.
    """
    path = Path(path)
    if (reader := _bag_reader(path)) is not None:
        from slam.files.logs import bag

        return bag.read(path, reader, topics or BagTopics())
    if topics is not None and any(topics):
        raise LogError(f"{path}: has no topics, as it is not a bag; leave out --scan-topic and --odom-topic")
    statistics = ReadStatistics(path)
    with closing(_readable_lines(statistics)) as lines:
        head = list(islice(lines, _HEAD))
        if head and (kind := foreign.named(head[0][1])):
            raise LogError(f"{path}: {kind}")
        for recognises, read in _FORMATS:
            if any(recognises(line) for _, line in head):
                return read(chain(head, lines), statistics)
    found = f"a file that begins with {head[0][1][:20]!r}" if head else "nothing"
    raise LogError("; ".join([f"{path}: not a log that hopslam can read: {found}", *statistics.notes, f"need {_NEED}"]))


def _bag_reader(path: Path) -> Callable[[Path], Iterator[RawMessage]] | None:
    """Return a reader of the messages of the bag at a path; None if it is not a bag."""
    if path.is_dir():
        return _folder_reader(path)
    try:
        with path.open("rb") as file:
            head = file.read(len(rosbag1.MAGIC))
    except OSError:
        return None
    if head == rosbag1.MAGIC:
        return rosbag1.messages
    if head.startswith(_MCAP):
        return _mcap
    return _rosbag2_file if head.startswith((_SQLITE, _ZSTD)) else None


def _folder_reader(path: Path) -> Callable[[Path], Iterator[RawMessage]] | None:
    """Return a reader of a run's log in its folder, or of a ROS 2 bag."""
    from slam.files.logs import rosbag2

    if (path / RUN_LOG).is_file() and not (path / rosbag2.METADATA).is_file():
        return lambda folder: _mcap(folder / RUN_LOG)
    return rosbag2.messages if rosbag2.is_bag(path) else None


def _mcap(path: Path) -> Iterator[RawMessage]:
    from slam.files.ros.mcap_files import mcap_messages

    return mcap_messages(path)


def _rosbag2_file(path: Path) -> Iterator[RawMessage]:
    from slam.files.logs import rosbag2

    return rosbag2.file_messages(path)


def _readable_lines(statistics: ReadStatistics) -> Generator[tuple[int, bytes], None, None]:
    """Yield the numbered lines as far as the file can be read."""
    try:
        yield from read_lines(statistics.path)
    except TruncatedFile as cut:
        statistics.notes.append(cut.note)
