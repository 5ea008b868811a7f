"""What of a bag matters to a replay."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeVar

from slam.errors import LogError
from slam.files.fields import BadLine
from slam.files.read_statistics import ReadStatistics
from slam.files.ros.raw_message import RawMessage
from slam.files.ros.topics import GROUND_TRUTH, LASER_SCAN, ODOMETRY, POSE, TF_STATIC, TRANSFORMS
from slam.files.text_lines import CutShort

_WANTED: Final = (LASER_SCAN, ODOMETRY, TRANSFORMS)
Value = TypeVar("Value")
Numbered = tuple[int, RawMessage]


@dataclass(slots=True)
class BagContents:
    """The messages of scans, odometry, transforms and truth, each with its number from 1, by type and topic."""

    tally: ReadStatistics
    by_type: dict[str, dict[str, list[Numbered]]] = field(default_factory=dict)

    @classmethod
    def read(cls, messages: Iterable[RawMessage], tally: ReadStatistics) -> BagContents:
        """What is in these messages, up to where they are damaged; the others are counted by type."""
        contents = cls(tally)
        try:
            for number, raw in enumerate(messages, 1):
                if raw.type in _WANTED or (raw.type == POSE and raw.topic == GROUND_TRUTH):
                    contents.by_type.setdefault(raw.type, {}).setdefault(raw.topic, []).append((number, raw))
                else:
                    tally.ignored[raw.type or "unknown"] += 1
        except CutShort:
            tally.notes.append("the bag is damaged or ends early, and what comes after that is lost")
        return contents

    def chosen(self, kind: str, wanted: str | None, option: str) -> list[Numbered]:
        """The messages of the one topic of a type, or of the wanted one; none where there is no such topic.

        LogError where there are more, or where the wanted one is not among them.
        """
        topics: Mapping[str, list[Numbered]] = self.by_type.get(kind, {})
        names = ", ".join(sorted(topics)) or "none"
        if wanted is not None:
            match = [topic for topic in topics if topic.lstrip("/") == wanted.lstrip("/")]
            if not match:
                raise LogError(f"{self.tally.path}: {option} {wanted}: not among its topics of {kind}: {names}")
            return topics[match[0]]
        if len(topics) > 1:
            raise LogError(f"{self.tally.path}: {len(topics)} topics of {kind}: {names}; choose one: {option} NAME")
        return next(iter(topics.values()), [])

    def transforms(self, static: bool) -> list[Numbered]:
        """The messages of ``/tf_static``, or those of all other topics of transforms."""
        topics = self.by_type.get(TRANSFORMS, {})
        return [raw for topic, raws in topics.items() if (topic == TF_STATIC) == static for raw in raws]

    def decoded(self, raws: Iterable[Numbered], decode: Callable[[RawMessage], Value]) -> Iterator[Value]:
        """The values of the messages; those that are garbled are skipped."""
        for number, raw in raws:
            try:
                yield decode(raw)
            except BadLine as fault:
                self.tally.skip(str(fault), number)
