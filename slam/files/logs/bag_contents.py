"""Messages of a bag that a replay needs, by type and topic."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.files.logs.bag_scans import parse_laser_scan
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.ros.decoder import Transform, decode_odometry, decode_pose, decode_transforms
from slam.files.ros.messages import (
    GROUND_TRUTH,
    LASER_SCAN,
    MULTI_ECHO,
    ODOMETRY,
    POSE,
    TF_STATIC,
    TRANSFORMS,
    RawMessage,
)  # fmt: skip
from slam.files.unpacking import TruncatedFile

_SCANS: Final = (LASER_SCAN, MULTI_ECHO)
_DECODERS: Final[dict[str, Callable[[RawMessage, int], Any]]] = {
    LASER_SCAN: parse_laser_scan,
    MULTI_ECHO: parse_laser_scan,
    ODOMETRY: lambda raw, _: decode_odometry(raw),
    TRANSFORMS: lambda raw, _: decode_transforms(raw),
    POSE: lambda raw, _: decode_pose(raw),
}
"""Decoder of a message and its number, by type."""


class Fault(NamedTuple):
    """Fault of a message."""

    kind: str
    detail: str


class Numbered(NamedTuple):
    """Number of a message from 1, and its decoded content."""

    number: int
    value: Any


@dataclass(slots=True)
class BagContents:
    """Messages of scans, odometry, transforms and true poses, decoded as they are read, by type and topic.

    A scan is kept without its ranges; a garbled message is replaced by its fault.
    """

    statistics: ReadStatistics
    by_type: dict[str, dict[str, list[Numbered]]] = field(default_factory=dict)

    @classmethod
    def read(cls, messages: Iterable[RawMessage], statistics: ReadStatistics) -> BagContents:
        """Sort these messages, until they are damaged or too many.

        Messages of other types are counted.
        """
        contents, scans = cls(statistics), 0
        try:
            for number, raw in enumerate(messages, 1):
                if raw.type not in _DECODERS or (raw.type == POSE and raw.topic != GROUND_TRUTH):
                    statistics.ignored[raw.type or "unknown"] += 1
                    continue
                scans += raw.type in _SCANS
                if statistics.is_full(scans):
                    break
                topics = contents.by_type.setdefault(raw.type, {})
                topics.setdefault(raw.topic, []).append(Numbered(number, _decoded(raw, number)))
        except TruncatedFile as cut:
            statistics.notes.append(cut.note)
        return contents

    def messages_of(self, wanted: str | None, option: str, *kinds: str) -> list[Numbered]:
        """Return the messages of one topic of these types: of ``wanted``, or else of the topic with the most messages.

        If one of several topics was chosen, a note lists them all. The result is empty if there is no such topic.

        LogError if the wanted topic is not among them.
        """
        topics: Mapping[str, list[Numbered]] = ChainMap(*(self.by_type.get(kind, {}) for kind in kinds))
        if wanted is not None:
            match = [topic for topic in topics if topic.lstrip("/") == wanted.lstrip("/")]
            if not match:
                names = ", ".join(sorted(topics)) or "none"
                raise LogError(
                    f"{self.statistics.path}: {option} {wanted}: not among its topics of {kinds[0]}: {names}"
                )
            return topics[match[0]]
        often = sorted(topics, key=lambda topic: (-len(topics[topic]), topic))
        if len(often) > 1:
            names = ", ".join(f"{topic} ({len(topics[topic])})" for topic in often)
            self.statistics.notes.append(
                f"{len(often)} topics of {kinds[0]}: {names}; {often[0]} is read, {option} NAME chooses another"
            )
        return topics[often[0]] if often else []

    def transforms(self, static: bool) -> list[Transform]:
        """The transforms of ``/tf_static``, or those of all other topics."""
        topics = self.by_type.get(TRANSFORMS, {})
        found = [one for topic, many in topics.items() if (topic == TF_STATIC) == static for one in many]
        return [transform for transforms in self.values(found) for transform in transforms]

    def values(self, messages: Iterable[Numbered], scans: bool = False) -> Iterator[Any]:
        """Yield the contents of the messages, which are scans or not; garbled ones are skipped."""
        for number, value in messages:
            if isinstance(value, Fault):
                self.statistics.skip(value.kind, number, value.detail, scan=scans)
            else:
                yield value


def _decoded(raw: RawMessage, number: int) -> Any:
    try:
        return _DECODERS[raw.type](raw, number)
    except BadLine as fault:
        return Fault(str(fault), fault.detail)
