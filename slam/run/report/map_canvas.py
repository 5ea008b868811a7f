"""One picture after another of a map that grows: what stays is drawn once, what moves on a copy."""

from __future__ import annotations

from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from slam.pose import FloatArray, Pose2D
from slam.run.results.palette import PAPER
from slam.run.results.plan import ROBOT, Plan
from slam.run.results.run_record import RunRecord

_FINE: Final = 2
"""Drawn so many times larger and then reduced: smooth lines."""
_SCAN: Final = "#f28e2b"
_WHITE: Final = "#ffffff"
_NAMES: Final = (
    ("mapped lines", PAPER.wall), ("scan", _SCAN), ("SLAM", PAPER.slam), ("dead reckoning", PAPER.odometry)
)  # fmt: skip
_HEAD: Final = 34
"""Pixels above the map, for the time and the colours' names."""
_TALLEST: Final = 1.1
"""Height over width at most."""


class MapCanvas:
    """The map of one run, from above."""

    def __init__(self, record: RunRecord, width: int) -> None:
        self._traces = traces = record.traces
        plan = Plan(record.walls, traces.estimate, traces.odometry, traces.truth, record.outlines)
        self._low, high = plan.extent
        extent = high - self._low
        self._scale = _FINE * width * min(1.0, _TALLEST * extent[0] / extent[1]) / extent[0]
        size = np.ceil(self._scale * extent).astype(int) // _FINE * _FINE
        self._size = int(size[0]), int(size[1]) + _FINE * _HEAD
        self._map = Image.new("RGB", self._size, _WHITE)
        self._font = ImageFont.load_default(_FINE * max(9, width // 68))
        for outline in record.outlines:
            ImageDraw.Draw(self._map).polygon(self._pixels(outline), fill=PAPER.solid)

    def add_lines(self, ends: FloatArray) -> None:
        """Draw lines (M, 2, 2), metres, map frame, that stay."""
        draw = ImageDraw.Draw(self._map)
        for segment in ends:
            draw.line(self._pixels(segment), fill=PAPER.wall, width=2 * _FINE)

    def picture(self, k: int, scan: FloatArray) -> Image.Image:
        """The picture at the scan ``k`` of the run, which saw the points ``scan`` (N, 2), metres, map frame."""
        traces = self._traces
        image = self._map.copy()
        draw = ImageDraw.Draw(image)
        self._dots(draw, scan)
        self._way(draw, traces.odometry[: k + 1], PAPER.odometry, 2)
        self._way(draw, traces.estimate[: k + 1], PAPER.slam, 2)
        draw.polygon(self._pixels(Pose2D(*traces.estimate[k]).transform(ROBOT)), fill=PAPER.slam)
        self._head(draw, k)
        return image.resize((self._size[0] // _FINE, self._size[1] // _FINE), Image.Resampling.LANCZOS)

    def _dots(self, draw: ImageDraw.ImageDraw, points: FloatArray) -> None:
        for x, y in self._pixels(points):
            draw.ellipse((x - _FINE, y - _FINE, x + _FINE, y + _FINE), fill=_SCAN)

    def _way(self, draw: ImageDraw.ImageDraw, poses: FloatArray, colour: str, width: int) -> None:
        if len(poses) > 1:
            draw.line(self._pixels(poses[:, :2]), fill=colour, width=_FINE * width, joint="curve")

    def _head(self, draw: ImageDraw.ImageDraw, k: int) -> None:
        """The time, and what the colours mean."""
        x, y = 6 * _FINE, 7 * _FINE
        for text, colour in ((f"{self._traces.stamps[k] - self._traces.stamps[0]:5.1f} s", PAPER.faint), *_NAMES):
            draw.text((x, y), text, fill=colour, font=self._font)
            x += int(draw.textlength(text, font=self._font)) + 14 * _FINE

    def _pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Points (N, 2), metres, map frame, y up, as pixels, y down."""
        pixels = self._scale * (points - self._low)
        pixels[:, 1] = self._size[1] - pixels[:, 1]
        return [(x, y) for x, y in pixels.tolist()]
