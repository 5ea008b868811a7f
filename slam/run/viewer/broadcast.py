"""Frames to all files and viewers of one run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

import numpy as np

from slam.run.viewer.blueprint import UNKNOWN, extent_of
from slam.run.viewer.chunks import Chunk
from slam.run.viewer.events import Event
from slam.run.viewer.feed import FILE_PACE, LIVE_PACE, Feed, Pace
from slam.run.viewer.frame import Frame
from slam.run.viewer.scene import Scene
from slam.run.viewer.sinks import FileOutlet, LiveOutlet, Sink


class Broadcast:
    """Files get many scans at once, which costs least; viewers get each scan as it comes. Use it as a context manager.

    ``say`` tells the user, in one line, of viewers that are not there.
    """

    def __init__(self, files: Sequence[Path], urls: Sequence[str], setting: Scene, say: Callable[[str], None]) -> None:
        self._outlets: list[Sink] = []
        self._feeds: list[Feed] = []
        self._file = FileOutlet(sorted(set(files)), setting) if files else None
        self._unknown = extent_of(setting) is UNKNOWN
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        if self._file is not None:
            self._add(FILE_PACE, setting, self._file)
        if urls:
            self._add(LIVE_PACE, setting, *(LiveOutlet(url, setting, say) for url in urls))

    def show(self, frame: Frame, events: Sequence[Event] = ()) -> None:
        """Show one scan."""
        self._low = np.minimum(self._low, frame.points.min(axis=0, initial=np.inf))
        self._high = np.maximum(self._high, frame.points.max(axis=0, initial=-np.inf))
        for feed in self._feeds:
            feed.show(frame, events)

    def tell(self, event: Event) -> None:
        """Show an event that came without a scan."""
        for feed in self._feeds:
            feed.tell(event)

    def put(self, chunks: Sequence[Chunk]) -> None:
        """Show these now."""
        for feed in self._feeds:
            feed.put(chunks)

    def _add(self, pace: Pace, setting: Scene, *outlets: Sink) -> None:
        self._outlets += outlets
        self._feeds.append(Feed([outlet.send for outlet in outlets], pace, setting))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for feed in self._feeds:
            feed.close()
        if self._file is not None and self._unknown and np.isfinite(self._high - self._low).all():
            self._file.look_at((self._low, self._high))
        for outlet in self._outlets:
            outlet.close()
