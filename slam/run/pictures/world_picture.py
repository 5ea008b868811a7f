"""A floor plan of a scenario's world, with people and movable furniture."""

import os
from collections.abc import Sequence
from itertools import pairwise
from math import cos, sin
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from slam.errors import InputError
from slam.files.atomic_files import atomic_file
from slam.pose import FloatArray
from slam.run.pictures.figure_style import PAPER, figure_size, save_figure
from slam.run.pictures.map_picture import ROBOT
from slam.scenario.schema import Scenario
from slam.scenario.solids import Prism
from slam.scenario.world_plan import Person

_FORMATS = (".png", ".svg", ".pdf")
_LONGEST = 8.0
"""Length of the longer side, inches."""
_LIGHT, _DARK = "0.82", "0.2"
_ROUTE, _PEOPLE, _START = PAPER.slam, PAPER.odometry, PAPER.accent


def check_picture(path: Path, option: str = "--out") -> None:
    """Raise InputError for a file that a picture cannot be written to; the message refers to ``option``."""
    if path.suffix not in _FORMATS:
        raise InputError(
            f"{path}: a picture needs a name that ends in {', '.join(_FORMATS)}; choose another {option} FILE"
        )
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written there; choose another {option} FILE")


def draw_world(path: Path, scenario: Scenario) -> None:
    """Write the plan to ``path``, whose suffix is the format; metres, map frame.

    Solids in the lidar's plane are dark, lower or higher ones light.
    """
    prisms, height = scenario.world.prisms(), scenario.lidar.height
    low, high = _extent(prisms, scenario)
    size = figure_size(_LONGEST * (high - low) / (high - low).max(), (5.0, 1.2), (0.8, 1.0))
    figure = Figure(figsize=size, dpi=180, layout="constrained")
    axes = figure.add_subplot()
    axes.grid(color="0.93", linewidth=0.6)
    axes.set_axisbelow(True)
    cut = [prism.bottom <= height <= prism.top for prism in prisms]
    _draw_solids(axes, [p for p, seen in zip(prisms, cut, strict=True) if not seen], _LIGHT, 1.0)
    _draw_solids(axes, [p for p, seen in zip(prisms, cut, strict=True) if seen], _DARK, 2.0)
    for person in scenario.people:
        _draw_person(axes, person)
    _draw_route(axes, scenario)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    key = [Patch(color=_DARK, label=f"cut at {height:g} m"), Patch(color=_LIGHT, label="lower or higher")]
    shown = [*key, *axes.get_legend_handles_labels()[0]]
    unique = list({str(handle.get_label()): handle for handle in shown}.values())
    figure.legend(handles=unique, loc="outside upper center", ncols=len(unique), fontsize="small", frameon=False)
    with atomic_file(path) as draft:
        save_figure(figure, draft)


def _draw_solids(axes: Axes, prisms: Sequence[Prism], colour: str, zorder: float) -> None:
    outlines = [prism.footprint for prism in prisms]
    axes.add_collection(PolyCollection(outlines, facecolors=colour, edgecolors=colour, linewidths=0.3, zorder=zorder))


def _draw_person(axes: Axes, person: Person) -> None:
    """Draw the path, and a dot at each way-point."""
    ends = np.array([*person.waypoints, person.waypoints[0]] if person.closed else person.waypoints)
    axes.plot(*ends.T, "--o", color=_PEOPLE, linewidth=1.0, markersize=3, label="people", zorder=3)


def _draw_route(axes: Axes, scenario: Scenario) -> None:
    """Draw the route from the start pose, with an arrow on each leg, and the robot in its true size."""
    start = scenario.robot.start.pose
    route = np.array([(start.x, start.y), *scenario.route.waypoints])
    if len(route) > 1:
        axes.plot(*route.T, ".-", color=_ROUTE, linewidth=1.2, label="route", zorder=4)
    for a, b in pairwise(route):
        middle = (a + b) / 2.0
        style = {"arrowstyle": "-|>", "color": _ROUTE}
        axes.annotate("", middle + 0.01 * (b - a), middle - 0.01 * (b - a), arrowprops=style, zorder=4)
    axes.fill(*start.transform(ROBOT).T, color=_START, label="start", zorder=5)
    axes.plot(
        [start.x, start.x + 0.5 * cos(start.theta)], [start.y, start.y + 0.5 * sin(start.theta)], color=_START, zorder=5
    )


def _extent(prisms: Sequence[Prism], scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corner of the drawing, with a margin."""
    start = scenario.robot.start
    moving = [(start.x, start.y), *scenario.route.waypoints, *(w for p in scenario.people for w in p.waypoints)]
    corners = np.concatenate([np.array(moving), *(prism.footprint for prism in prisms)])
    return corners.min(axis=0) - 0.6, corners.max(axis=0) + 0.6
