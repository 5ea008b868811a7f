"""Messages of a bag that matter to a replay, by type and topic."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeVar

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.files.logs.read_statistics import ReadStatistics
from slam.files.ros import decoder
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

_WANTED: Final = (LASER_SCAN, MULTI_ECHO, ODOMETRY, TRANSFORMS)
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

    def messages_of(self, wanted: str | None, option: str, *kinds: str) -> list[Numbered]:
        """The messages of one topic of these types: of the wanted one, or else of that with the most messages, which a
        note then names with the others; none where there is no such topic.

        LogError where the wanted one is not among them.
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
                self.statistics.skip(str(fault), number, fault.detail, scan=False)
