"""The episode from above, as an image: a fixed background, and a few strokes per frame."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from slam.env.occupancy_grid import Extent, seen_ranges
from slam.env.step_state import StepState
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scan import LaserScan
from slam.scenario.schema import Scenario

_LONG_SIDE, _SHORT_SIDE, _BLOCK = 960, 160, 16
"""Pixels: the longer side, the least shorter side, and the divisor of both, for video codecs."""
_BODY: Final = np.array([[0.155, -0.19], [0.21, -0.10], [0.21, 0.10], [0.155, 0.19], [-0.245, 0.19], [-0.245, -0.19]])
"""Outline of the robot, base frame, metres."""
_NOSE: Final = np.array([[0.0, 0.0], [0.21, 0.0]])

_FLOOR, _SOLID, _ROUTE = (250, 250, 247), (70, 74, 82), (186, 186, 186)
_FAN, _ECHO, _LINE = (255, 205, 60, 70), (190, 140, 0), (0, 114, 178)
_TRUTH, _ESTIMATE, _GOAL, _PERSON = (30, 30, 30), (213, 94, 0), (138, 43, 226), (105, 192, 240)


class TopView:
    """Pictures of one size; each scenario is scaled to fit."""

    def __init__(self, scenario: Scenario, extent: Extent) -> None:
        width, height = extent.size
        scale = _LONG_SIDE / max(width, height)
        self.size = (_pixels(width * scale), _pixels(height * scale))
        self.show(scenario, extent)

    def show(self, scenario: Scenario, extent: Extent) -> None:
        """Draw the background: floor, solids and route of this scenario."""
        self._scale = min(self.size[0] / extent.size[0], self.size[1] / extent.size[1])
        self._middle = np.array(extent.low) + np.array(extent.size) / 2
        self._background = Image.new("RGB", self.size, _FLOOR)
        draw = ImageDraw.Draw(self._background)
        for outline in scenario.world.outlines(scenario.lidar.height):
            draw.polygon(self._at(outline), fill=_SOLID)
        if scenario.route.waypoints:
            draw.line(self._at(np.array(scenario.path)), fill=_ROUTE, width=2)

    def frame(self, state: StepState, lines: FloatArray) -> NDArray[np.uint8]:
        """Draw this state as (height, width, 3), with the map ``lines`` (M, 2, 2), map frame, and the known poses."""
        image = self._background.copy()
        draw = ImageDraw.Draw(image, "RGBA")
        self._draw_scan(draw, state.observation.scan, state.T_map_laser)
        for line in self._pixels_of(lines):
            draw.line(line.ravel().tolist(), fill=_LINE, width=2)
        for person in state.observation.people:
            self._disc(draw, np.array(person), 0.22, fill=_PERSON)
        if state.goal is not None:
            self._disc(draw, state.goal.translation, 0.2, outline=_GOAL, width=3)
        if state.truth is not None:
            self._draw_robot(draw, state.truth, _TRUTH, (120, 125, 135))
        if state.estimate is not None:
            self._draw_robot(draw, state.estimate.T_map_base, _ESTIMATE, None)
        return np.array(image)

    def _draw_scan(self, draw: Any, scan: LaserScan, T_map_laser: Pose2D) -> None:
        """Draw the fan that the beams swept, and a dot at every echo."""
        lengths, headings = seen_ranges(scan), scan.lidar.angles
        ends = T_map_laser.transform(lengths[:, None] * unit_vectors(headings))
        draw.polygon(self._at(np.concatenate([T_map_laser.translation[None], ends[lengths > 0.0]])), fill=_FAN)
        draw.point(self._at(ends[scan.echoes]), fill=_ECHO)

    def _draw_robot(self, draw: Any, T_map_base: Pose2D, colour: tuple[int, ...], fill: tuple[int, ...] | None) -> None:
        draw.polygon(self._at(T_map_base.transform(_BODY)), fill=fill, outline=colour, width=2)
        draw.line(self._at(T_map_base.transform(_NOSE)), fill=colour, width=2)

    def _disc(self, draw: Any, center: FloatArray, radius: float, **style: Any) -> None:
        x, y = self._pixels_of(center)
        size = max(radius * self._scale, 3.0)
        draw.ellipse([x - size, y - size, x + size, y + size], **style)

    def _at(self, points: FloatArray) -> list[float]:
        """Return pixels of these points (N, 2) in Pillow's form: x0, y0, x1, ..."""
        flat: list[float] = self._pixels_of(points).ravel().tolist()
        return flat

    def _pixels_of(self, points: FloatArray) -> FloatArray:
        """Return columns and rows of these points (..., 2), metres, map frame; y points up."""
        return (points - self._middle) * self._scale * [1.0, -1.0] + np.array(self.size) / 2


def _pixels(length: float) -> int:
    return max(_SHORT_SIDE, round(length / _BLOCK) * _BLOCK)
