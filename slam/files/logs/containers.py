"""What kind of bag is at a path; the readers are imported when there is one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

from slam.files.ros.raw_message import RawMessage

Messages = Callable[[Path], Iterable[RawMessage]]
_ROS1: Final = b"#ROSBAG V2.0\n"
_MCAP: Final = b"\x89MCAP0\r\n"
_RUN_LOG: Final = "log.mcap"


def container(path: Path) -> Messages | None:
    """How to read the messages of the bag at a path; None where there is no bag."""
    if path.is_dir():
        return _folder(path)
    try:
        with path.open("rb") as file:
            head = file.read(len(_ROS1))
    except OSError:
        return None
    if head == _ROS1:
        from slam.files.logs import rosbag1

        return rosbag1.messages
    return _mcap() if head.startswith(_MCAP) else None


def _folder(path: Path) -> Messages | None:
    """Of the folder of a run, its log; of another one with metadata, what these say; else the MCAP file alone in it."""
    if (path / "metadata.yaml").is_file():
        from slam.files.logs import rosbag2

        return rosbag2.messages
    files = [path / _RUN_LOG] if (path / _RUN_LOG).is_file() else list(path.glob("*.mcap"))
    if len(files) != 1:
        return None
    messages = _mcap()
    return lambda _: messages(files[0])


def _mcap() -> Messages:
    from slam.files.ros.mcap_messages import mcap_messages

    return mcap_messages
