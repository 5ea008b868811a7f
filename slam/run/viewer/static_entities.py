"""Entities that never change: the true walls, the planned route, the outline of the robot, colours and sizes."""

from collections.abc import Iterator
from typing import Final

import numpy as np
import rerun as rr

from slam.run.viewer import palette
from slam.run.viewer.chunks import at_height
from slam.run.viewer.scene import PLOTS, Scene

_BODY: Final = np.array([[0.21, -0.10], [0.21, 0.10], [0.13, 0.19], [-0.30, 0.19], [-0.30, -0.19], [0.13, -0.19]])
"""Outline of the P3-DX, base frame, metres."""
_NOSE: Final = np.array([[0.0, -0.09], [0.17, 0.0], [0.0, 0.09]])


def static_entities(scene: Scene) -> Iterator[tuple[str, rr.AsComponents]]:
    """Yield the entities that are logged once, and the styles of those that are logged at every scan."""
    walls = [at_height(np.vstack([outline, outline[:1]]), -0.01) for outline in scene.outlines]
    yield "map/walls", rr.LineStrips3D(walls, colors=palette.TRUE_WALLS, radii=rr.Radius.ui_points(0.75))
    if scene.route is not None and len(scene.route) > 1:
        route = at_height(scene.route, -0.005)
        yield "map/route", rr.LineStrips3D([route], colors=palette.ROUTE, radii=rr.Radius.ui_points(0.75))
        yield "map/route/waypoints", rr.Points3D(route, colors=palette.ROUTE, radii=rr.Radius.ui_points(3.0))
    yield from _robot()
    yield from _looks()
    for name in scene.plots:
        curves = PLOTS[name].curves
        colours = palette.SERIES[: len(curves)]
        yield f"plots/{name}", rr.SeriesLines(names=curves, colors=colours, widths=[1.5] * len(curves))


def _robot() -> Iterator[tuple[str, rr.AsComponents]]:
    for name, shape, colour in (("body", _BODY, palette.BODY), ("nose", _NOSE, palette.SLAM)):
        corners = at_height(shape, 0.0 if name == "body" else 0.005)
        fan = [(0, i, i + 1) for i in range(1, len(shape) - 1)]
        yield f"map/robot/{name}", rr.Mesh3D(vertex_positions=corners, triangle_indices=fan, albedo_factor=colour)
    outline = at_height(np.vstack([_BODY, _BODY[:1]]), 0.01)
    yield "map/robot/outline", rr.LineStrips3D([outline], colors=palette.SLAM, radii=rr.Radius.ui_points(1.0))


def _looks() -> Iterator[tuple[str, rr.AsComponents]]:
    """Yield colours and sizes; sizes are in points of the screen, to be visible at any distance."""
    points = rr.Radius.ui_points
    yield "map/scan", rr.Points3D.from_fields(radii=points(1.6))
    yield "map/scan", rr.Transform3D(translation=(0.0, 0.0, 0.03))
    yield "map/sonar", rr.Points3D.from_fields(colors=palette.SONAR, radii=points(3.0))
    yield "map/segments", rr.LineStrips3D.from_fields(radii=points(1.5))
    yield "map/segments", rr.Points3D.from_fields(radii=points(3.0))
    yield "map/points", rr.Points3D.from_fields(colors=palette.MAP_POINTS, radii=points(1.2))
    yield "map/lines", rr.LineStrips3D.from_fields(colors=palette.MAP_LINES, radii=points(1.0))
    trajectories = (("slam", palette.SLAM, 1.8), ("odometry", palette.ODOMETRY, 1.2), ("truth", palette.TRUTH, 0.6))
    for name, colour, width in trajectories:
        yield f"map/trajectory/{name}", rr.LineStrips3D.from_fields(colors=colour, radii=points(width))
    yield "map/trajectory/closed", rr.LineStrips3D.from_fields(colors=palette.CLOSED, radii=points(1.2))
    yield "map/loops", rr.LineStrips3D.from_fields(colors=palette.LOOP, radii=points(1.0))
    yield "map/loops", rr.Points3D.from_fields(colors=palette.LOOP, radii=points(3.5))
    yield "map/loops/doubted", rr.LineStrips3D.from_fields(colors=palette.DOUBT, radii=points(1.0))
    ellipses = rr.Ellipsoids3D.from_fields(colors=palette.UNSURE, line_radii=points(1.0), fill_mode="MajorWireframe")
    yield "map/robot", ellipses
    yield "map/robot", rr.Arrows3D.from_fields(colors=palette.UNSURE, radii=points(1.5))
