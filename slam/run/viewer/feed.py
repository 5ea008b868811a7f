"""A watcher that gathers what is to be shown of the scans, and hands it on in batches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import monotonic
from typing import Final

from slam.run.viewer.chunks import Chunk, event_chunk, frame_chunks, stroke_chunks
from slam.run.viewer.events import Event
from slam.run.viewer.frame import Frame
from slam.run.viewer.map_layer import MapLayer
from slam.run.viewer.plots import plot_chunks
from slam.run.viewer.setting import Setting

FILE_PERIOD: Final = 0.85
"""Seconds of wall time between two batches for files: what kill -9 can cost. The head of a chunk is over 1 kB ..."""
LIVE_PERIOD: Final = 0.09
"""... but eyes want every scan at 10 Hz."""
_SLOWER: Final = 3
"""Curves and trajectories, which are most of the chunks, go with every third batch."""
_MOST: Final = 256
"""Scans in a batch, however fast they come."""


class Feed:
    """Frames in, chunks out."""

    def __init__(self, sends: Sequence[Callable[[Sequence[Chunk]], None]], period: float, setting: Setting) -> None:
        self._sends, self._period, self._plots = sends, period, setting.plots
        self._layer = None if setting.slam is None else MapLayer(setting.slam)
        self._frames: list[Frame] = []
        self._trail: list[Frame] = []
        self._events: list[Event] = []
        self._before: Frame | None = None  # the last of the strokes that were sent
        self._last: Frame | None = None
        self._batches = 0
        self._sent_at = 0.0  # so that the first scan is there at once

    def show(self, frame: Frame, events: Sequence[Event]) -> None:
        """Take one scan; send, when it is time."""
        self._frames.append(frame)
        self._events += events
        if monotonic() - self._sent_at >= self._period or len(self._frames) >= _MOST:
            self.flush()

    def put(self, chunks: Sequence[Chunk]) -> None:
        """Send these now."""
        for send in self._sends:
            send(chunks)

    def tell(self, event: Event) -> None:
        """Take an event that came without a scan."""
        self._events.append(event)

    def flush(self, last: bool = False) -> None:
        """Send what was gathered; the map too if it is due."""
        chunks: list[Chunk] = []
        if frames := self._frames:
            chunks += frame_chunks(frames)
            self._trail += frames
            self._last, self._frames = frames[-1], []
        self._batches += 1
        if self._trail and (last or self._batches % _SLOWER == 1):
            chunks += [*stroke_chunks(self._before, self._trail), *plot_chunks(self._trail, self._plots)]
            self._before, self._trail = self._trail[-1], []
        if self._events:
            chunks.append(event_chunk(self._events))
            self._events = []
        if self._layer is not None and self._last is not None:
            chunks += self._layer.chunks(self._last, last)
        if chunks:
            self.put(chunks)
        self._sent_at = monotonic()
