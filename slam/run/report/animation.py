"""An animated WebP or GIF of the map of a run as it grows."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image
from scipy.spatial import cKDTree

from slam.errors import InputError
from slam.files.atomic_files import atomic_file, require_writable
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D
from slam.run.pictures.loop_lines import loops_until
from slam.run.pictures.map_picture import contents_of
from slam.run.report.map_canvas import MapCanvas
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import Traces

_PIECE: Final = 0.08
"""Length of the pieces in which walls appear, metres."""
_NEAR: Final = 0.12
"""Distance of a scan point at which a piece appears, metres."""
_RATE: Final = 10.0
"""Pictures per second."""
_STILL: Final = 2500
"""Duration of the last picture, milliseconds."""
_FORMATS: Final = {".webp": "WEBP", ".gif": "GIF"}


class AppearingWalls:
    """The walls of the saved map, each piece from the first time it is seen."""

    def __init__(self, walls: FloatArray) -> None:
        self._unseen = _pieces(walls)

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """Return new pieces (M, 2, 2), metres, map frame: those near the points (N, 2) of this scan only."""
        if not len(points) or not len(self._unseen):
            return self._unseen[:0]
        distance, _ = cKDTree(points).query(self._unseen.mean(axis=1), distance_upper_bound=_NEAR)
        new = np.isfinite(distance)
        pieces: FloatArray = self._unseen[new]
        self._unseen = self._unseen[~new]
        return pieces


class AppearingSegments:
    """The segments of every scan, for the paper's map, which has no other lines."""

    def __init__(self, record: RunRecord) -> None:
        self._scans, self._ends = record.segments
        self._drawn = 0

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """Return new segments (M, 2, 2), metres, map frame: those of this scan and of the skipped ones before it."""
        begin, self._drawn = self._drawn, int(np.searchsorted(self._scans, scan, side="right"))
        ends: FloatArray = self._ends[begin : self._drawn]
        return ends


class GrowingMap:
    """The map as estimated scan by scan.

    Walls seen before the last closed loop are drawn at their final positions, and later ones where they were estimated
    when they were seen.
    """

    def __init__(self, record: RunRecord, canvas: MapCanvas) -> None:
        self._traces, self._canvas = record.traces, canvas
        self._lines = AppearingSegments(record) if record.saved_map is None else AppearingWalls(record.walls)
        self._loops = None if contents_of(record).loops is None else record.graph
        self._closures = _closures(record.traces)
        self._drawn: list[FloatArray] = []  # at their final positions
        self._since = 0  # scan of the last closure

    def picture(self, k: int, points: FloatArray, last: bool) -> Image.Image:
        """Draw the picture at the scan ``k``, which saw these points (N, 2), base frame.

        The last picture shows the final map.
        """
        traces = self._traces
        at, final = Pose2D.from_array(traces.estimate[k]), Pose2D.from_array(traces.final[k])
        new = self._lines.seen(k, final.transform(points))
        self._drawn.append(new)
        since = len(traces.stamps) if last and self._loops else int(self._closures[k])
        if since > self._since:
            self._since, at = since, final if last else at
            self._canvas.clear()
            self._canvas.add_lines(np.concatenate(self._drawn))
            if self._loops is not None:
                self._canvas.add_loops(loops_until(self._loops, traces.final, k))
        else:
            self._canvas.add_lines((at @ final.inverse()).transform(new.reshape(-1, 2)).reshape(-1, 2, 2))
        path = np.concatenate([traces.final[: self._since], traces.estimate[self._since : k + 1]])[: k + 1]
        return self._canvas.picture(k, at.transform(points), path)


def _closures(traces: Traces) -> IntArray:
    """Return for each scan the index of the scan at which the last closure was applied, (K,); 0 before the first."""
    jumps = traces.jumps if traces.closed is not None else np.zeros(len(traces.stamps), np.bool_)
    return np.asarray(np.maximum.accumulate(np.where(jumps, np.arange(len(jumps)), 0)))


def _pieces(walls: FloatArray) -> FloatArray:
    """Return the walls cut into short pieces, (P, 2, 2)."""
    parts = [np.empty((0, 2, 2))]
    for start, end in walls:
        corners = np.linspace(start, end, 1 + max(1, round(float(np.hypot(*(end - start))) / _PIECE)))
        parts.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(parts)


def write_animation(record: RunRecord, path: Path, seconds: float = 8.0, width: int = 960) -> None:
    """Write the animation at once or not at all.

    It plays for ``seconds``, in a loop. InputError for another suffix, and for a log without scans.
    """
    if path.suffix not in _FORMATS:
        raise InputError(f"{path}: an animation needs a name that ends in .webp or .gif; choose another --out FILE")
    frames = list(_frames(record, round(seconds * _RATE), width))
    if not frames:
        raise InputError(f"{record.folder}: its log was cut off before the first scan; there is nothing to draw")
    durations = [round(1000 / _RATE)] * (len(frames) - 1) + [_STILL]
    options = {"quality": 70, "method": 4} if path.suffix == ".webp" else {"optimize": True}
    with require_writable(path, "choose another --out FILE"), atomic_file(path) as draft:
        frames[0].save(
            draft, format=_FORMATS[path.suffix], save_all=True, append_images=frames[1:], duration=durations,
            loop=0, **options,
        )  # fmt: skip


def _frames(record: RunRecord, count: int, width: int) -> Iterator[Image.Image]:
    """Yield ``count`` pictures, evenly over the scans of the run, including the last one."""
    growing = GrowingMap(record, MapCanvas(record, width))
    last = len(record.traces.stamps) - 1
    shown = set(np.unique(np.linspace(0, last, count).astype(int)).tolist())
    for k, observation in enumerate(record.observations()):
        if k in shown:
            yield growing.picture(k, record.T_base_laser.transform(observation.scan.points()), k == last)
