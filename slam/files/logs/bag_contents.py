"""Messages of a bag that matter to a replay, and the scans in them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeVar

import numpy as np

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.ros import decoder
from slam.files.ros.messages import GROUND_TRUTH, LASER_SCAN, ODOMETRY, POSE, TF_STATIC, TRANSFORMS, RawMessage
from slam.files.unpacking import TruncatedFile
from slam.lidars import Lidar
from slam.pose import FloatArray

_WANTED: Final = (LASER_SCAN, ODOMETRY, TRANSFORMS)
Value = TypeVar("Value")
Numbered = tuple[int, RawMessage]


@dataclass(slots=True)
class BagContents:
    """The messages of scans, odometry, transforms and truth, each with its number from 1, by type and topic."""

    statistics: ReadStatistics
    by_type: dict[str, dict[str, list[Numbered]]] = field(default_factory=dict)

    @classmethod
    def read(cls, messages: Iterable[RawMessage], statistics: ReadStatistics) -> BagContents:
        """Sort these messages, up to where they are damaged; those that do not matter are counted by type."""
        contents = cls(statistics)
        try:
            for number, raw in enumerate(messages, 1):
                if raw.type in _WANTED or (raw.type == POSE and raw.topic == GROUND_TRUTH):
                    contents.by_type.setdefault(raw.type, {}).setdefault(raw.topic, []).append((number, raw))
                else:
                    statistics.ignored[raw.type or "unknown"] += 1
        except TruncatedFile as cut:
            statistics.notes.append(cut.note)
        return contents

    def messages_of(self, kind: str, wanted: str | None, option: str) -> list[Numbered]:
        """The messages of the one topic of a type, or of the wanted one; none where there is no such topic.

        LogError where there are more, or where the wanted one is not among them.
        """
        topics: Mapping[str, list[Numbered]] = self.by_type.get(kind, {})
        names = ", ".join(sorted(topics)) or "none"
        if wanted is not None:
            match = [topic for topic in topics if topic.lstrip("/") == wanted.lstrip("/")]
            if not match:
                raise LogError(f"{self.statistics.path}: {option} {wanted}: not among its topics of {kind}: {names}")
            return topics[match[0]]
        if len(topics) > 1:
            raise LogError(
                f"{self.statistics.path}: {len(topics)} topics of {kind}: {names}; choose one: {option} NAME"
            )
        return next(iter(topics.values()), [])

    def transforms(self, static: bool) -> list[decoder.Transform]:
        """The transforms of ``/tf_static``, or those of all other topics."""
        topics = self.by_type.get(TRANSFORMS, {})
        raws = [raw for topic, raws in topics.items() if (topic == TF_STATIC) == static for raw in raws]
        return [one for many in self.decoded(raws, decoder.decode_transforms) for one in many]

    def decoded(self, raws: Iterable[Numbered], decode: Callable[[RawMessage], Value]) -> Iterator[Value]:
        """The values of the messages; those that are garbled are skipped."""
        for number, raw in raws:
            try:
                yield decode(raw)
            except BadLine as fault:
                self.statistics.skip(str(fault), number)


@dataclass(frozen=True, slots=True, eq=False)
class BagScan:
    """One scan; ``line`` is the number of its message. Ranges in metres, as REP-117 has them; times in seconds.

    ``fan`` says nothing of ``scan_time``, which is that of the whole log.
    """

    line: int
    stamp: float
    frame: str
    fan: Lidar
    ranges: FloatArray
    time_increment: float


def parse_laser_scan(raw: RawMessage, number: int) -> BagScan:
    """The scan in a message; BadLine when it is cut or says what cannot be."""
    scan = decoder.decode(raw)
    beams, step = len(scan.ranges), scan.angle_increment
    turn = (beams - 1) * step
    possible = step > 0.0 and scan.range_max > scan.range_min and abs(scan.angle_min) < 7.0
    if beams < 1 or not possible or turn >= 2.0 * np.pi + 1e-3 or not abs(scan.time_increment) < 1.0:
        raise BadLine("impossible value")
    ranges = decoder.decimal_ranges(scan.ranges)
    finite = np.isfinite(ranges)
    ranges[finite & (scan.ranges > scan.range_max)] = np.inf  # REP 117: no echo ...
    ranges[finite & (scan.ranges < scan.range_min)] = -np.inf  # ... and too close, which says nothing of free space
    reach = decoder.decimal(scan.range_min), decoder.decimal(scan.range_max)
    fan = Lidar(*decoder.exact_bearings(scan.angle_min, step), beams, *reach, scan_time=0.0)
    frame, between = decoder.frame_name(scan.header.frame_id), decoder.decimal(scan.time_increment)
    return BagScan(number, decoder.seconds(scan.header), frame, fan, ranges, between)
