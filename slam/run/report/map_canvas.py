"""Draws a sequence of pictures of a growing map: the background once, moving parts on a copy."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from slam.pose import FloatArray, Pose2D
from slam.run.pictures.figure_style import PAPER
from slam.run.pictures.loop_lines import LoopLines
from slam.run.pictures.map_picture import ROBOT, contents_of
from slam.run.results.run_record import RunRecord

_FINE: Final = 2
"""Factor by which pictures are drawn larger and then reduced, for smooth lines."""
_WHITE: Final = "#ffffff"
_NAMES: Final = (
    ("mapped lines", PAPER.wall), ("scan", PAPER.accent), ("SLAM", PAPER.slam), ("dead reckoning", PAPER.odometry),
    ("loops", PAPER.loop),
)  # fmt: skip
_GAP: Final = 14
"""Space between the names of colours, and in all above and below their rows, pixels."""
_NARROWEST: Final = 160
"""Least width, pixels, with room for every name."""
_TALLEST: Final = 1.1
"""Largest ratio of height to width."""


class MapCanvas:
    """Draws the map of one run, from above."""

    def __init__(self, record: RunRecord, width: int) -> None:
        self._traces = record.traces
        self._low, high = contents_of(record).extent
        extent = high - self._low
        self._scale = _FINE * width * min(1.0, _TALLEST * extent[0] / extent[1]) / extent[0]
        size = np.ceil(self._scale * extent).astype(int) // _FINE * _FINE
        across = max(int(size[0]), _FINE * _NARROWEST)
        letters = _FINE * max(9, min(width, across // _FINE) // 68)
        self._font = ImageFont.load_default(letters)
        names = _NAMES if record.graph is not None and record.graph.loops else _NAMES[:-1]
        self._names, head = self._placed(names, across, letters)
        self._size = across, int(size[1]) + head
        self._outlines = record.outlines
        self.clear()

    def clear(self) -> None:
        """Clear the background."""
        self._map = Image.new("RGB", self._size, _WHITE)
        for outline in self._outlines:
            ImageDraw.Draw(self._map).polygon(self._pixels(outline), fill=PAPER.solid)

    def add_lines(self, ends: FloatArray) -> None:
        """Draw lines (M, 2, 2), metres, map frame, on the background."""
        draw = ImageDraw.Draw(self._map)
        for segment in ends:
            draw.line(self._pixels(segment), fill=PAPER.wall, width=2 * _FINE)

    def add_loops(self, loops: LoopLines) -> None:
        """Draw loops on the background, doubtful ones crossed out."""
        draw = ImageDraw.Draw(self._map)
        for ends, believed in zip(loops.ends, loops.believed, strict=True):
            colour = PAPER.loop if believed else PAPER.doubt
            draw.line(self._pixels(ends), fill=colour, width=2 * _FINE)
            (x, y), r = self._pixels(ends.mean(axis=0)[None])[0], 3 * _FINE
            if believed:
                draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)
            else:
                draw.line((x - r, y - r, x + r, y + r), fill=colour, width=_FINE)
                draw.line((x - r, y + r, x + r, y - r), fill=colour, width=_FINE)

    def picture(self, k: int, scan: FloatArray, path: FloatArray) -> Image.Image:
        """Draw the picture at the scan ``k`` of the run, which saw the points ``scan`` (N, 2), metres, map frame.

        ``path`` (k + 1, 3) is the robot's path so far.
        """
        traces = self._traces
        image = self._map.copy()
        draw = ImageDraw.Draw(image)
        for x, y in self._pixels(scan):
            draw.ellipse((x - _FINE, y - _FINE, x + _FINE, y + _FINE), fill=PAPER.accent)
        self._draw_path(draw, traces.odometry[: k + 1], PAPER.odometry)
        self._draw_path(draw, path, PAPER.slam)
        draw.polygon(self._pixels(Pose2D.from_array(path[-1]).transform(ROBOT)), fill=PAPER.slam)
        time = f"{traces.stamps[k] - traces.stamps[0]:5.1f} s"
        for place, text, colour in self._names:
            draw.text(place, text or time, fill=colour, font=self._font)
        return image.resize((self._size[0] // _FINE, self._size[1] // _FINE), Image.Resampling.LANCZOS)

    def _draw_path(self, draw: ImageDraw.ImageDraw, poses: FloatArray, colour: str) -> None:
        if len(poses) > 1:
            draw.line(self._pixels(poses[:, :2]), fill=colour, width=2 * _FINE, joint="curve")

    def _placed(
        self, names: Sequence[tuple[str, str]], across: int, letters: int
    ) -> tuple[list[tuple[tuple[int, int], str, str]], int]:
        """Place the time (an empty text) and the names in as many rows as necessary; also return the rows' height."""
        gap, height = _FINE * _GAP, 3 * letters // 2
        x, y, places = gap // 2, gap // 2, []
        for text, colour in (("", PAPER.faint), *names):
            length = int(self._font.getlength(text or "10000.0 s"))
            if x + length > across - gap // 2:
                x, y = gap // 2, y + height
            places.append(((x, y), text, colour))
            x += length + gap
        return places, (y + height + gap // 2) // _FINE * _FINE

    def _pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Convert points (N, 2), metres, map frame, y up, to pixels, y down."""
        pixels = self._scale * (points - self._low)
        pixels[:, 1] = self._size[1] - pixels[:, 1]
        return [(x, y) for x, y in pixels.tolist()]
