"""Initial layout of the viewer: the map from above, y up, beside the curves and the events."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from slam.pose import FloatArray
from slam.run.viewer import palette
from slam.run.viewer.scene import PLOTS, Scene

Extent = tuple[FloatArray, FloatArray]
"""Lower and upper corner (2,), metres, map frame."""

UNKNOWN: Final[Extent] = (np.array([-8.0, -6.0]), np.array([8.0, 6.0]))
_LONG: Final = 2.5
"""Ratio of width to depth from which the world is shown above the curves; others are shown beside them."""
_WIDE, _BESIDE = (3.0, 1.02), (1.55, 1.02)
"""Width and depth of the ground that the eye sees in a 16:9 window, per metre of height."""
_MARGIN: Final = 1.06
_ALL: Final = rrb.TimeRangeBoundary.infinite()
_NOW: Final = rrb.TimeRangeBoundary.cursor_relative()
_SO_FAR: Final = rrb.VisibleTimeRanges(
    [rrb.VisibleTimeRange(timeline, start=_ALL, end=_NOW) for timeline in ("time", "scan")]
)
_TITLE: Final = (
    "map: SLAM blue, with loops closed green, truth yellow, dead reckoning orange, planned violet; "
    "loops lime, doubtful ones pink and crossed out; walls: mapped white, true grey"
)
_STROKES: Final = ("slam", "odometry", "truth")


def blueprint(extent: Extent, plots: Sequence[str]) -> rrb.Blueprint:
    """Place the eye over the middle of the extent, high enough to see all of it.

    It follows the robot if the extent is unknown; the time follows the newest scan.
    """
    return rrb.Blueprint(
        _layout(extent, plots),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="following"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def extent_of(scene: Scene) -> Extent:
    """Return the extent of the world known before the first scan."""
    grown = None if scene.slam is None else scene.slam.points.points
    more = [points for points in (scene.route, scene.around, grown) if points is not None]
    points = np.concatenate([*scene.outlines, *more, np.empty((0, 2))])
    return UNKNOWN if len(points) < 2 else (points.min(axis=0), points.max(axis=0))


def _layout(extent: Extent, plots: Sequence[str]) -> rrb.Container:
    width, depth = extent[1] - extent[0]
    curves = [_curves(name) for name in plots]
    if width > _LONG * depth:
        below = rrb.Horizontal(*curves, _events(), column_shares=[*(1.0 for _ in curves), 1.5])
        return rrb.Vertical(_plan(extent, _WIDE), below, row_shares=[2.2, 1.0])
    beside = rrb.Vertical(*curves, _events(), row_shares=[*(1.0 for _ in curves), 1.3])
    return rrb.Horizontal(_plan(extent, _BESIDE), beside, column_shares=[3.0, 1.0])


def _plan(extent: Extent, sight: tuple[float, float]) -> rrb.Spatial3DView:
    low, high = extent
    (x, y), (width, depth) = (low + high) / 2, high - low
    height = _MARGIN * float(max(width / sight[0], depth / sight[1], 2.0))
    ground = rr.components.Plane3D.XY.with_distance(-0.05)
    return rrb.Spatial3DView(
        name=_TITLE,
        origin="/map",
        background=rrb.Background(color=palette.GROUND),
        line_grid=rrb.LineGrid3D(visible=True, spacing=1.0, plane=ground, stroke_width=0.5, color=palette.GRID),
        eye_controls=rrb.EyeControls3D(
            position=(x, y, height),
            look_target=(x, y, 0.0),
            eye_up=(0, 1, 0),
            tracking_entity="/map/robot" if extent is UNKNOWN else None,
        ),
        overrides={f"map/trajectory/{name}": [_SO_FAR] for name in _STROKES},
    )


def _curves(name: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        name=PLOTS[name].title,
        origin=f"plots/{name}",
        axis_x=rrb.TimeAxis(view_range=rr.TimeRange(start=_ALL, end=_ALL)),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=len(PLOTS[name].curves) > 1),
    )


def _events() -> rrb.TextLogView:
    columns = rrb.TextLogColumns(timeline_columns=["time"], text_log_columns=["LogLevel", "Body"])
    return rrb.TextLogView(name="events", origin="events", columns=columns)
