"""The curves beside the map, as rerun draws them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import rerun as rr

from slam.run.viewer.chunks import Chunk, times_of
from slam.run.viewer.curves import PLOTS
from slam.run.viewer.frame import Frame
from slam.run.viewer.palette import SERIES


def plot_chunks(frames: Sequence[Frame], names: Sequence[str]) -> Iterator[Chunk]:
    """The points of these curves at these scans."""
    when = times_of(frames)
    for name in names:
        values = np.array([PLOTS[name].values(frame) for frame in frames], np.float64)
        columns = rr.Scalars.columns(scalars=values.ravel()).partition([values.shape[1]] * len(frames))
        yield Chunk(f"plots/{name}", when, columns)


def plot_styles(names: Sequence[str]) -> Iterator[tuple[str, rr.SeriesLines]]:
    """Names and colours of the curves, by entity."""
    for name in names:
        curves = PLOTS[name].curves
        looks = SERIES[: len(curves)]
        yield f"plots/{name}", rr.SeriesLines(names=curves, colors=looks, widths=[1.5] * len(curves))
