"""What happened in a run, in words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from slam.run.step import Step

Level = Literal["INFO", "WARN", "ERROR"]


@dataclass(frozen=True, slots=True)
class Event:
    """One line of the log, at one scan."""

    scan: int
    stamp: float
    level: Level
    text: str


class EventWatch:
    """Turns steps into events: each thing is told when it begins, and being lost and stalled also when it ends."""

    def __init__(self) -> None:
        self._on: dict[str, bool] = {}

    def of(self, step: Step) -> Iterator[Event]:
        """What is new in this step."""
        for level, text in self._news(step):
            yield Event(step.index, step.estimate.stamp, level, text)

    def _news(self, step: Step) -> Iterator[tuple[Level, str]]:
        seen, match = step.observation, step.estimate.match
        if step.index == 0:
            yield "INFO", f"first scan: {len(seen.scan.ranges)} beams to {seen.scan.range_max:g} m"
        if step.timeouts:
            yield "WARN", f"the robot was silent: {step.timeouts} timeout{'s' * (step.timeouts > 1)} before this scan"
        if (lost := self._changed("lost", step.estimate.lost)) is not None:
            yield ("WARN", "lost: the scans do not fit the map") if lost else ("INFO", "sure of its place again")
        if self._changed("searched", match.searched):
            yield "INFO", f"odometry in doubt: searched around it, {match.inliers:.0f} of {match.points} pieces agree"
        if (stalled := self._changed("stalled", seen.stalled)) is not None:
            yield ("WARN", "stalled: a wheel cannot turn") if stalled else ("INFO", "the wheels turn again")
        if self._changed("bumped", any(seen.bumpers)):
            yield "WARN", "a bumper is pressed"
        if self._changed("collided", seen.collided):
            yield "ERROR", "collided"

    def _changed(self, name: str, now: bool) -> bool | None:
        """The new state, None where it is the old."""
        before, self._on[name] = self._on.get(name, False), now
        return now if now != before else None
