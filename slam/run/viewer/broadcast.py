"""Frames to all files and viewers of one run."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

import numpy as np

from slam.run.viewer.batcher import FILE_PACE, LIVE_PACE, Batcher, Pace
from slam.run.viewer.blueprint import UNKNOWN, extent_of
from slam.run.viewer.chunks import Chunk
from slam.run.viewer.scene import Event, Frame, Scene
from slam.run.viewer.sinks import RecordingSink, ViewerSink


class Broadcast:
    """Files get many scans at once, which costs least; viewers get each scan as it comes. Use it as a context manager.

    ``say`` tells the user, in one line, of viewers that are not there.
    """

    def __init__(self, files: Sequence[Path], urls: Sequence[str], scene: Scene, say: Callable[[str], None]) -> None:
        self._sinks: list[RecordingSink | ViewerSink] = []
        self._batchers: list[Batcher] = []
        self._file = RecordingSink(sorted(set(files)), scene) if files else None
        self._unknown = extent_of(scene) is UNKNOWN
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        if self._file is not None:
            self._add(FILE_PACE, scene, self._file)
        if urls:
            self._add(LIVE_PACE, scene, *(ViewerSink(url, scene, say) for url in urls))

    def show(self, frame: Frame, events: Sequence[Event] = ()) -> None:
        """Show one scan."""
        self._low = np.minimum(self._low, frame.points.min(axis=0, initial=np.inf))
        self._high = np.maximum(self._high, frame.points.max(axis=0, initial=-np.inf))
        for batcher in self._batchers:
            batcher.show(frame, events)

    def add_event(self, event: Event) -> None:
        """Show an event that came without a scan."""
        for batcher in self._batchers:
            batcher.add_event(event)

    def send(self, chunks: Sequence[Chunk]) -> None:
        """Show these now."""
        for batcher in self._batchers:
            batcher.send(chunks)

    def _add(self, pace: Pace, scene: Scene, *sinks: RecordingSink | ViewerSink) -> None:
        self._sinks += sinks
        self._batchers.append(Batcher([sink.send for sink in sinks], pace, scene))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for batcher in self._batchers:
            batcher.close()
        if self._file is not None and self._unknown and np.isfinite(self._high - self._low).all():
            self._file.set_view((self._low, self._high))
        for sink in self._sinks:
            sink.close()
