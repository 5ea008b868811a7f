"""Collects frames and events, and sends them as chunks in batches, with the growing map."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from time import monotonic
from typing import Final, NamedTuple

from slam.pose import FloatArray
from slam.run.estimator import Estimator
from slam.run.viewer.chunks import Chunk, event_chunk, frame_chunks, loop_chunks, map_chunks, plot_chunks, stroke_chunks
from slam.run.viewer.scene import Event, Frame, Scene

_BYTES_PER_SCAN: Final = 500.0
_MIN_WAIT: Final = 20
"""Scans between two maps."""
_MAX_POINTS, _MAX_LINES = 4000, 2000
"""Number of map points above which the map is thinned evenly."""
Send = Callable[[Sequence[Chunk]], None]
_MAX_SCANS: Final = 256
"""Largest number of scans in a batch."""


class MapSnapshot(NamedTuple):
    """The map at one scan."""

    scan: int
    stamp: float
    points: FloatArray
    """(N, 2): points."""
    ends: FloatArray
    """(M, 2, 2): walls."""


class MapUpdates:
    """Watches how a map grows."""

    def __init__(self, slam: Estimator) -> None:
        self._slam = slam
        self._shown, self._due, self._moved = -1, 0, False

    def move(self) -> None:
        """The map has moved as a whole: it is due at once."""
        self._due, self._moved = 0, True

    def due(self, frame: Frame, last: bool = False) -> MapSnapshot | None:
        """Return the map at this scan, if it has changed and is due, or is the last."""
        size = len(self._slam.points)
        if not size or (frame.index < self._due and not last) or (size == self._shown and not self._moved):
            return None
        points = _thinned(self._slam.points.points, _MAX_POINTS)
        lines = _thinned(self._slam.lines.ends, _MAX_LINES)
        sent = 12 * len(points) + 24 * len(lines)
        self._moved = False
        self._shown, self._due = size, frame.index + max(_MIN_WAIT, round(sent / _BYTES_PER_SCAN))
        return MapSnapshot(frame.index, frame.stamp, points, lines)


def _thinned(array: FloatArray, most: int) -> FloatArray:
    return array[:: len(array) // most + 1].copy()  # the map continues to grow


class BatchPeriods(NamedTuple):
    """Seconds of wall time between two batches, of the scans and of data that changes slowly, or costs most."""

    scans: float
    trail: float
    """Curves and trajectories, which are most of the chunks."""


FILE_PACE: Final = BatchPeriods(0.85, 0.85)
"""For files: seconds of data that kill -9 may lose. Longer batches have less overhead, over 1 kB per chunk."""
LIVE_PACE: Final = BatchPeriods(0.09, 0.85)
"""For viewers: every scan at 10 Hz is visible."""


class Batch(NamedTuple):
    """Frames, events and map that are sent to the viewers at once."""

    frames: Sequence[Frame]
    trail: Sequence[Frame]
    """Frames whose curves and strokes are due."""
    before: Frame | None
    """Frame at which the strokes begin."""
    events: Sequence[Event]
    map: MapSnapshot | None

    def chunks(self, plots: Sequence[str]) -> Iterator[Chunk]:
        """Yield the chunks of the batch for rerun."""
        if self.frames:
            yield from frame_chunks(self.frames)
        for frame in self.frames:
            if frame.loops is not None:
                yield from loop_chunks(frame.index, frame.stamp, frame.loops)
        if self.trail:
            yield from stroke_chunks(self.before, self.trail)
            yield from plot_chunks(self.trail, plots)
        if self.events:
            yield event_chunk(self.events)
        if self.map is not None:
            yield from map_chunks(*self.map)


class Batcher:
    """Turns frames into chunks.

    A separate thread makes the chunks, one batch at a time; its errors are raised at the next batch.
    """

    def __init__(self, sends: Sequence[Send], pace: BatchPeriods, scene: Scene) -> None:
        self._sends, self._pace, self._plots = sends, pace, scene.plots
        self._map_updates = None if scene.slam is None else MapUpdates(scene.slam)
        self._frames: list[Frame] = []
        self._trail: list[Frame] = []
        self._events: list[Event] = []
        self._before: Frame | None = None  # end of the strokes that were sent
        self._last: Frame | None = None
        self._sent_at = self._trail_sent_at = 0.0  # so that the first scan is shown at once
        self._packer = ThreadPoolExecutor(1, "viewer feed")
        self._packing: Future[None] | None = None

    def show(self, frame: Frame, events: Sequence[Event]) -> None:
        """Take one scan; send a batch when it is due."""
        if frame.jumped and self._map_updates is not None:
            self._map_updates.move()
        self._frames.append(frame)
        self._trail.append(frame)
        self._events += events
        self._last = frame
        if monotonic() - self._sent_at >= self._pace.scans or len(self._frames) >= _MAX_SCANS:
            self._flush()

    def add_event(self, event: Event) -> None:
        """Take an event that came without a scan."""
        self._events.append(event)

    def send(self, chunks: Sequence[Chunk]) -> None:
        """Send these chunks unchanged."""
        self._submit(lambda: chunks)

    def close(self) -> None:
        """Send everything, and the final map."""
        self._flush(last=True)
        self._packer.shutdown()
        self._wait()

    def _flush(self, last: bool = False) -> None:
        now = self._sent_at = monotonic()
        trail: list[Frame] = []
        if last or now - self._trail_sent_at >= self._pace.trail or len(self._trail) >= _MAX_SCANS:
            trail, self._trail, self._trail_sent_at = self._trail, [], now
        snapshot = None
        if self._map_updates is not None and self._last is not None:
            snapshot = self._map_updates.due(self._last, last)
        batch = Batch(self._frames, trail, self._before, self._events, snapshot)
        self._before = trail[-1] if trail else self._before
        self._frames, self._events = [], []
        self._submit(lambda: list(batch.chunks(self._plots)))

    def _submit(self, make: Callable[[], Sequence[Chunk]]) -> None:
        self._wait()
        self._packing = self._packer.submit(self._pack, make)

    def _wait(self) -> None:
        if self._packing is not None:
            self._packing.result()

    def _pack(self, make: Callable[[], Sequence[Chunk]]) -> None:
        if chunks := make():
            for send in self._sends:
                send(chunks)
