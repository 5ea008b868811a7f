"""``log.mcap``: the raw record of a run, written scan by scan, and readable up to any interruption."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NamedTuple, Self

from slam.closing import Closing
from slam.errors import InputError
from slam.files.logs.read import RUN_LOG
from slam.files.ros.decoder import Transform, decode_odometry, decode_pose, decode_scan, decode_transforms
from slam.files.ros.encoder import Encoder, nanoseconds
from slam.files.ros.mcap_files import McapWriter, mcap_messages, mcap_note
from slam.files.ros.messages import GROUND_TRUTH, ODOM, SCAN, TF, TF_STATIC, RawMessage
from slam.files.unpacking import TruncatedFile
from slam.odometry import Odometry
from slam.pose import Pose2D
from slam.robot import Observation
from slam.run.results.step_messages import StepMessages
from slam.run.step import Step

_SCANS_PER_CHUNK: Final = 8
"""Largest chunk size; larger chunks are not smaller when packed."""
_LOST: Final = 1.0
"""Seconds of a killed run that may be lost: those in an incomplete chunk."""
_BYTES_BESIDE: Final = 31
"""Size of a message's record in MCAP, without the message."""
_KNOWN_MAP: Final = "hopslam:known_map"


class KnownMap(NamedTuple):
    """The saved map that a run continued."""

    map: str
    """Path of the map, as the user gave it."""
    start: str
    """Start of the robot in the map: see ``--start``."""

    @classmethod
    def of(cls, notes: Mapping[str, Any]) -> Self | None:
        """Read the map and the start from the notes of an experiment, or its metrics; None without a saved map."""
        return cls(str(notes["map"]), str(notes.get("start", "search"))) if "map" in notes else None


class RunLog(Closing):
    """Watcher that appends every step to ``log.mcap``; the scan is the last message of a step."""

    def __init__(
        self, folder: Path, T_base_laser: Pose2D, known_map: KnownMap | None = None,
        messages: StepMessages | None = None,
    ) -> None:  # fmt: skip
        self._path, self._T_base_laser, self._known_map = folder / RUN_LOG, T_base_laser, known_map
        self._encoder, self._messages = Encoder(), messages or StepMessages()
        self._writer: McapWriter | None = None

    def on_step(self, step: Step) -> None:
        """Write one step."""
        messages = self._messages.of(step)
        writer = self._writer or self._begin(step, sum(len(message) + _BYTES_BESIDE for message in messages.values()))
        for topic, message in messages.items():
            writer.write(topic, nanoseconds(step.observation.scan.stamp), message)

    def close(self) -> None:
        """Write the index, and sync everything to the disk."""
        if self._writer is not None:
            self._writer.close()

    def _begin(self, step: Step, step_size: int) -> McapWriter:
        """Open the file, and write the mount of the lidar; ``step_size`` is the size of a step, bytes."""
        scan = step.observation.scan
        self._writer = McapWriter(self._path, self._encoder, _chunk_size(step_size, scan.scan_time))
        if self._known_map is not None:
            self._writer.note(_KNOWN_MAP, self._known_map._asdict())
        mount = self._encoder.transforms(scan.stamp, ("base_link", "laser", self._T_base_laser))
        self._writer.write(TF_STATIC, nanoseconds(scan.stamp), mount)
        return self._writer


def _chunk_size(step_size: int, scan_time: float) -> int:
    """Return the chunk size for steps of this size and duration; for slow steps each message has its own chunk.

    A kill loses the steps of the last chunk, and one more, because a chunk can end within a step.
    """
    steps = int(_LOST / scan_time + 1e-6) - 1 if scan_time > 0.0 else 0
    return step_size * min(steps, _SCANS_PER_CHUNK) if steps > 1 else 1


def logged_observations(path: Path) -> Iterator[Observation]:
    """Yield the observations of the robot, scan by scan; ranges in single precision.

    InputError if there is no such file.
    """
    odometry, truth = Odometry(0.0, Pose2D()), None
    for message in logged_messages(path):
        if message.topic == ODOM:
            odometry = decode_odometry(message).odometry
        elif message.topic == GROUND_TRUTH:
            truth = decode_pose(message).pose
        elif message.topic == SCAN:
            yield Observation(decode_scan(message), odometry, truth)


def logged_mount(path: Path) -> Pose2D:
    """Return ``T_base_laser``; InputError if there is no such file or it ends before that."""
    return _first_transforms(path, TF_STATIC)[0].pose


def logged_start(path: Path) -> Pose2D:
    """Return the estimated ``T_map_base`` at the first scan; InputError in the same cases."""
    T_odom_base, T_map_odom = _first_transforms(path, TF)
    return T_map_odom.pose @ T_odom_base.pose


def logged_known_map(path: Path) -> KnownMap | None:
    """Return the map that the run continued; None if it began its own, or has no log."""
    if not path.is_file():
        return None
    note = mcap_note(path, _KNOWN_MAP)
    return KnownMap.of(note)


def _first_transforms(path: Path, topic: str) -> list[Transform]:
    for message in logged_messages(path):
        if message.topic == topic:
            return decode_transforms(message)
    raise InputError(f"{path}: holds no scan; the run was ended before its first")


def logged_messages(path: Path) -> Iterator[RawMessage]:
    """Yield all messages in the order of the file; InputError if there is no such file."""
    try:
        with suppress(TruncatedFile):
            yield from mcap_messages(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; the folder of a run has this file") from error
