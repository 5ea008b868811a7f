"""The curves beside the map, as numbers."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, sqrt
from typing import Final, NamedTuple

from slam.run.viewer.frame import Frame


class Plot(NamedTuple):
    """One view of curves; ``values`` gives one number a curve, nan where there is none."""

    title: str
    curves: tuple[str, ...]
    values: Callable[[Frame], tuple[float, ...]]


def _position(frame: Frame) -> tuple[float, ...]:
    error = float("nan") if frame.truth is None else 100 * frame.truth.distance(frame.robot)
    C = frame.covariance
    return error, float("nan") if C is None else 100 * sqrt(max(C[0, 0] + C[1, 1], 0.0))


def _heading(frame: Frame) -> tuple[float, ...]:
    error = float("nan") if frame.truth is None else degrees(frame.truth.between(frame.robot).theta)
    C = frame.covariance
    return error, float("nan") if C is None else degrees(sqrt(max(C[2, 2], 0.0)))


PLOTS: Final = {
    "position": Plot("position, cm", ("error", "sigma"), _position),
    "heading": Plot("heading, degrees", ("error", "sigma"), _heading),
    "iterations": Plot("iterations", ("iterations",), lambda frame: (frame.iterations,)),
    "time": Plot(
        "time a scan, ms", ("all", "lines"), lambda frame: (1e3 * frame.total_time, 1e3 * frame.extraction_time)
    ),
    "command": Plot("command, m/s and rad/s", ("v", "omega"), lambda frame: frame.command),
}
