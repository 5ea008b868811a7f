"""The map of a run as it grows, as an animated WebP or GIF."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image
from scipy.spatial import cKDTree

from slam.errors import InputError
from slam.files.atomic_files import atomic_file, require_writable
from slam.pose import FloatArray, Pose2D
from slam.run.report.map_canvas import MapCanvas
from slam.run.results.run_record import RunRecord

_PIECE: Final = 0.08
"""Walls appear in pieces of this length, metres ..."""
_NEAR: Final = 0.12
"""... when a point of a scan lies so near to one, metres."""
_RATE: Final = 10.0
"""Pictures a second."""
_STILL: Final = 2500
"""Milliseconds for which the last one stands."""
_FORMATS: Final = {".webp": "WEBP", ".gif": "GIF"}


class AppearingWalls:
    """The walls of the saved map, each piece from when it was first seen."""

    def __init__(self, walls: FloatArray) -> None:
        self._unseen = _pieces(walls)

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """New pieces (M, 2, 2), metres, map frame: those near the points (N, 2) of this scan and of no earlier one."""
        if not len(points) or not len(self._unseen):
            return self._unseen[:0]
        distance, _ = cKDTree(points).query(self._unseen.mean(axis=1), distance_upper_bound=_NEAR)
        new = np.isfinite(distance)
        pieces: FloatArray = self._unseen[new]
        self._unseen = self._unseen[~new]
        return pieces


class AppearingSegments:
    """The segments of every scan, where the map is the paper's: it has no other lines."""

    def __init__(self, record: RunRecord) -> None:
        self._scans, self._ends = record.segments
        self._drawn = 0

    def seen(self, scan: int, points: FloatArray) -> FloatArray:
        """New segments (M, 2, 2), metres, map frame: those of this scan and of the ones that were left out."""
        begin, self._drawn = self._drawn, int(np.searchsorted(self._scans, scan, side="right"))
        ends: FloatArray = self._ends[begin : self._drawn]
        return ends


def _pieces(walls: FloatArray) -> FloatArray:
    """The walls cut into short pieces, (P, 2, 2)."""
    parts = [np.empty((0, 2, 2))]
    for start, end in walls:
        corners = np.linspace(start, end, 1 + max(1, round(float(np.hypot(*(end - start))) / _PIECE)))
        parts.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(parts)


def write_animation(record: RunRecord, path: Path, seconds: float = 8.0, width: int = 960) -> None:
    """Write it whole; it plays for ``seconds`` and begins again. InputError for a name that ends otherwise."""
    if path.suffix not in _FORMATS:
        raise InputError(f"{path}: an animation needs a name that ends in .webp or .gif; choose another --out FILE")
    frames = list(_frames(record, round(seconds * _RATE), width))
    durations = [round(1000 / _RATE)] * (len(frames) - 1) + [_STILL]
    options = {"quality": 70, "method": 4} if path.suffix == ".webp" else {"optimize": True}
    with require_writable(path, "choose another --out FILE"), atomic_file(path) as draft:
        frames[0].save(
            draft, format=_FORMATS[path.suffix], save_all=True, append_images=frames[1:], duration=durations,
            loop=0, **options,
        )  # fmt: skip


def _frames(record: RunRecord, count: int, width: int) -> Iterator[Image.Image]:
    """``count`` pictures, evenly over the scans of the run, the last scan among them."""
    canvas, traces = MapCanvas(record, width), record.traces
    lines = AppearingSegments(record) if record.saved_map is None else AppearingWalls(record.walls)
    shown = set(np.unique(np.linspace(0, len(traces.stamps) - 1, count).astype(int)).tolist())
    for k, observation in enumerate(record.observations()):
        if k in shown:
            points = (Pose2D.from_array(traces.estimate[k]) @ record.T_base_laser).transform(observation.scan.points())
            canvas.add_lines(lines.seen(k, points))
            yield canvas.picture(k, points)
