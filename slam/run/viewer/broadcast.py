"""Frames to all .rrd files and viewers of one run; viewers, over gRPC, may be slow, connect late, and disconnect."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, Full, Queue
from threading import Thread
from time import monotonic
from typing import Final

import numpy as np
import rerun as rr

from slam.closing import Closing
from slam.run.viewer.batcher import FILE_PACE, LIVE_PACE, Batcher, BatchPeriods
from slam.run.viewer.blueprint import UNKNOWN, Extent, blueprint, extent_of
from slam.run.viewer.chunks import Chunk
from slam.run.viewer.rerun_program import is_listening
from slam.run.viewer.scene import Event, Frame, Scene
from slam.run.viewer.static_entities import static_entities

_QUEUE: Final = 64
"""Batches that may wait for a viewer; older ones are dropped."""
_PATIENCE: Final = 2.0
"""Seconds for a viewer to take one batch."""
_RETRY: Final = 1.0
"""Seconds between two attempts to connect to a viewer."""
_FAREWELL: Final = 4.0
"""Seconds for a viewer to take the remaining batches at the end."""


class RecordingSink:
    """Writes files, complete when closed; a truncated one can be read up to its last batch."""

    def __init__(self, paths: Sequence[Path], scene: Scene) -> None:
        self._stream, self._plots = _stream(list(map(rr.FileSink, paths)), scene), scene.plots

    def send(self, chunks: Sequence[Chunk]) -> None:
        """Write a batch."""
        _send(self._stream, chunks)

    def set_view(self, extent: Extent) -> None:
        """Set the initial view of the file."""
        self._stream.send_blueprint(blueprint(extent, self._plots))

    def close(self) -> None:
        """Write the remaining data, and the footer."""
        self._stream.flush()
        self._stream.disconnect()


class ViewerSink:
    """A viewer at a gRPC address. ``send`` never waits: a thread does.

    rerun blocks its caller if a viewer does not read and its buffers are full, and for five seconds if there is no
    viewer; so this class checks for a viewer first, and passes it one batch at a time.
    """

    def __init__(self, url: str, scene: Scene, say: Callable[[str], None]) -> None:
        self._url, self._scene, self._say = url, scene, say
        self._batches: Queue[Sequence[Chunk] | None] = Queue(_QUEUE)
        self._stream: rr.RecordingStream | None = None
        self._missed = False
        self._look_at = 0.0
        self._thread = Thread(target=self._pump, name=f"viewer {url}", daemon=True)
        self._thread.start()

    def send(self, chunks: Sequence[Chunk]) -> None:
        """Queue a batch; the oldest is dropped if too many wait."""
        while True:
            try:
                return self._batches.put_nowait(chunks)
            except Full:
                with suppress(Empty):
                    self._batches.get_nowait()

    def close(self) -> None:
        """Give the viewer a moment to take the remaining batches."""
        with suppress(Full):
            self._batches.put(None, timeout=_FAREWELL)
        self._thread.join(_FAREWELL)

    def _pump(self) -> None:
        while (chunks := self._batches.get()) is not None:
            if self._stream is None:
                self._connect()
            if self._stream is not None:
                self._deliver(self._stream, chunks)
        if self._stream is not None:
            self._stream.disconnect()

    def _connect(self) -> None:
        if monotonic() < self._look_at:
            return
        self._look_at = monotonic() + _RETRY
        if is_listening(self._url):
            self._stream = _stream([rr.GrpcSink(self._url)], self._scene)
        elif not self._missed:
            self._missed = True
            self._say(f"no viewer at {self._url} yet; start one there with: rerun. The run goes on")

    def _deliver(self, stream: rr.RecordingStream, chunks: Sequence[Chunk]) -> None:
        try:
            _send(stream, chunks)
            stream.flush(timeout_sec=_PATIENCE)
        except RuntimeError:
            self._stream, self._missed = None, True
            stream.disconnect()
            self._say(f"the viewer at {self._url} does not answer any more; the run goes on")


def _stream(sinks: Sequence[rr.FileSink | rr.GrpcSink], scene: Scene) -> rr.RecordingStream:
    """Make a recording, with all static entities."""
    stream = rr.RecordingStream("hopslam", send_properties=False)
    stream.set_sinks(*sinks, default_blueprint=blueprint(extent_of(scene), scene.plots))
    for entity, archetype in static_entities(scene):
        stream.log(entity, archetype, static=True)
    return stream


def _send(stream: rr.RecordingStream, chunks: Sequence[Chunk]) -> None:
    for chunk in chunks:
        stream.send_columns(chunk.entity, chunk.indexes, chunk.columns)


class Broadcast(Closing):
    """Files get many scans at once, which is cheapest; viewers get each scan as it comes. Use it as a context manager.

    ``say`` prints one line to the user about viewers that do not answer.
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
        """Send these chunks now."""
        for batcher in self._batchers:
            batcher.send(chunks)

    def _add(self, pace: BatchPeriods, scene: Scene, *sinks: RecordingSink | ViewerSink) -> None:
        self._sinks += sinks
        self._batchers.append(Batcher([sink.send for sink in sinks], pace, scene))

    def close(self) -> None:
        """Send everything, and end the recordings."""
        for batcher in self._batchers:
            batcher.close()
        if self._file is not None and self._unknown and np.isfinite(self._high - self._low).all():
            self._file.set_view((self._low, self._high))
        for sink in self._sinks:
            sink.close()


def send_file(path: Path, url: str) -> None:
    """Send a recording to a running viewer."""
    stream = rr.RecordingStream("hopslam", send_properties=False)
    stream.set_sinks(rr.GrpcSink(url))
    stream.log_file_from_path(path)
    stream.flush()
    stream.disconnect()
