"""The map of a run as it grows, as an animated WebP or GIF."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image

from slam.errors import InputError
from slam.files.whole_files import whole_file
from slam.pose import Pose2D
from slam.run.report.growing_lines import growing_lines
from slam.run.report.map_canvas import MapCanvas
from slam.run.results.run_record import RunRecord

_RATE: Final = 10.0
"""Pictures a second."""
_STILL: Final = 2500
"""Milliseconds for which the last one stands."""
_FORMATS: Final = {".webp": "WEBP", ".gif": "GIF"}


def write_animation(record: RunRecord, path: Path, seconds: float = 8.0, width: int = 960) -> None:
    """Write it whole; it plays for ``seconds`` and begins again. InputError for a name that ends otherwise."""
    if path.suffix not in _FORMATS:
        raise InputError(f"{path}: an animation needs a name that ends in .webp or .gif; choose another --out FILE")
    frames = list(_frames(record, round(seconds * _RATE), width))
    durations = [round(1000 / _RATE)] * (len(frames) - 1) + [_STILL]
    options = {"quality": 70, "method": 4} if path.suffix == ".webp" else {"optimize": True}
    try:
        with whole_file(path) as draft:
            frames[0].save(
                draft, format=_FORMATS[path.suffix], save_all=True, append_images=frames[1:], duration=durations,
                loop=0, **options,
            )  # fmt: skip
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --out FILE") from error


def _frames(record: RunRecord, count: int, width: int) -> Iterator[Image.Image]:
    """So many pictures, evenly over the scans of the run, the last scan among them."""
    canvas, lines, traces = MapCanvas(record, width), growing_lines(record), record.traces
    shown = set(np.unique(np.linspace(0, len(traces.stamps) - 1, count).astype(int)).tolist())
    for k, observation in enumerate(record.observations()):
        if k in shown:
            points = (Pose2D.from_array(traces.estimate[k]) @ record.T_base_laser).transform(observation.scan.points())
            canvas.add_lines(lines.seen(k, points))
            yield canvas.picture(k, points)
