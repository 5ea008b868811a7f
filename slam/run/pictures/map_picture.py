"""``map.png``: the map from above."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from slam.files.atomic_files import atomic_file
from slam.files.graphs.file import read_graph
from slam.files.tum import read_tum
from slam.pose import FloatArray, Pose2D, compose_poses, inverse_poses
from slam.run.pictures.figure_style import PAPER, Palette, figure_size, plain_axes, save_figure
from slam.run.pictures.loop_lines import LoopLines, draw_loops
from slam.run.results.run_record import RunRecord
from slam.scenario.solids import rectangle

_MAX_POINTS: Final = 200_000
"""Number of map points above which they are thinned evenly for the picture."""
_MANY: Final = 3000
"""Number of segments above which they are drawn as pixels, even in a file of vector graphics."""
_MIDDLE: Final = "#7d8590"
"""Colour of the pixels, which no theme can change: visible on light and on dark."""
_FEW: Final = 500
"""Number of segments above which lines are fainter."""
ROBOT: Final = rectangle((-0.045, 0.0), 0.51, 0.38, 0.0)
"""The P3-DX, base frame, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class MapContents:
    """True walls, map, and trajectories of a map picture; metres, map frame."""

    walls: FloatArray
    """(M, 2, 2): start and end of each line of the map."""
    estimate: FloatArray
    """(K, 3) poses: x, y, heading."""
    odometry: FloatArray | None = None
    truth: FloatArray | None = None
    outlines: Sequence[FloatArray] = ()
    """(C, 2) each: the true walls."""
    points: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    loops: LoopLines | None = None
    name: str = "SLAM"
    """Name of the estimate."""

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner: all paths and true walls, and the map without the farthest 0.2 %."""
        paths = [path[:, :2] for path in (self.estimate, self.odometry, self.truth) if path is not None]
        mapped = np.concatenate([self.points, self.walls.reshape(-1, 2)])
        bulk = np.percentile(mapped, [0.1, 99.9], axis=0) if len(mapped) else np.empty((0, 2))
        corners = np.concatenate([bulk, *paths, *self.outlines])
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = 0.02 * float((high - low).max()) + 0.2
        return low - margin, high + margin


def contents_of(record: RunRecord) -> MapContents:
    """Return the final map, trajectories and loops of a run."""
    traces, graph = record.traces, record.graph
    loops = None if graph is None or traces.closed is None else LoopLines.of(graph, traces.closed)
    return MapContents(record.walls, traces.final, traces.odometry, traces.truth, record.outlines, loops=loops)


def contents_without_loops(record: RunRecord) -> MapContents | None:
    """Return the same without loop closing, with every seen segment as the map.

    None for a run without closed loops.
    """
    traces, graph = record.traces, record.graph
    if traces.local is None or traces.closed is None or graph is None:
        return None
    scans, ends = record.segments
    known = scans < len(traces.stamps)
    scans, ends = scans[known], ends[known]
    T_local_map = compose_poses(traces.local, inverse_poses(traces.estimate))[scans]
    loops = LoopLines.of(graph, traces.local)
    walls = transform_ends(T_local_map, ends)
    return MapContents(
        walls, traces.local, traces.odometry, traces.truth, record.outlines, loops=loops, name="SLAM without loops"
    )


def transform_ends(poses: FloatArray, ends: FloatArray) -> FloatArray:
    """Transform lines (M, 2, 2), each by its own pose (M, 3)."""
    c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x, y = ends[..., 0], ends[..., 1]
    return np.stack([poses[:, 0, None] + c * x - s * y, poses[:, 1, None] + s * x + c * y], axis=-1)


def draw_contents(axes: Axes, contents: MapContents, colours: Palette) -> None:
    """Draw everything, with labels for a legend."""
    low, high = contents.extent
    axes.add_collection(
        PolyCollection(
            list(contents.outlines), facecolors=colours.solid, edgecolors=colours.edge, linewidths=0.4, zorder=1,
            label="true walls" if len(contents.outlines) else "_",
        )
    )  # fmt: skip
    thinned = contents.points[:: len(contents.points) // _MAX_POINTS + 1]
    axes.plot(*thinned.T, ",", color=colours.point, alpha=0.4, zorder=2, rasterized=True)
    strength = max(0.25, min(1.0, (_FEW / max(len(contents.walls), 1)) ** 0.5))
    many = len(contents.walls) > _MANY
    axes.add_collection(
        LineCollection(
            list(contents.walls), colors=_MIDDLE if many else colours.wall, linewidths=0.5 + 1.1 * strength,
            alpha=0.4 + 0.6 * strength, zorder=3, capstyle="round", label="mapped lines", rasterized=many,
        )
    )  # fmt: skip
    _draw_ways(axes, contents, colours)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]", aspect="equal")


def _draw_ways(axes: Axes, contents: MapContents, colours: Palette) -> None:
    if contents.odometry is not None:
        axes.plot(*contents.odometry.T[:2], color=colours.odometry, linewidth=1.3, label="dead reckoning", zorder=4)
        axes.plot(*contents.odometry[-1, :2], "o", color=colours.odometry, markersize=4, zorder=4)
    axes.plot(*contents.estimate.T[:2], color=colours.slam, linewidth=2.0, label=contents.name, zorder=5)
    if contents.truth is not None:
        axes.plot(*contents.truth.T[:2], color=colours.truth, linewidth=0.8, dashes=(4, 3), label="truth", zorder=6)
    robot = Pose2D(*contents.estimate[-1]).transform(ROBOT)
    axes.fill(*robot.T, facecolor=colours.slam, alpha=0.35, linewidth=0.0, zorder=7)
    axes.fill(*robot.T, facecolor="none", edgecolor=colours.slam, linewidth=1.2, zorder=7)
    if contents.loops is not None:
        draw_loops(axes, contents.loops, colours)


def draw_map(folder: Path, points: FloatArray, segment_ends: FloatArray, outlines: Sequence[FloatArray]) -> None:
    """Write ``map.png`` into a run folder that has at least one step.

    ``points`` (N, 2), ``segment_ends`` (M, 2, 2) and the true wall ``outlines`` are in metres, map frame; the
    trajectories, and the loops if there are any, are read from the folder.
    """
    closed, truth = (_poses(folder / f"{name}.tum") for name in ("closed", "groundtruth"))
    estimate, odometry = (read_tum(folder / f"{name}.tum")[1] for name in ("trajectory", "odometry"))
    loops = None if closed is None else LoopLines.of(read_graph(folder / "graph.json"), closed)
    final = estimate if closed is None else closed
    contents = MapContents(segment_ends, final, odometry, truth, outlines, points, loops)
    with atomic_file(folder / "map.png") as draft:
        save_figure(map_figure(contents), draft, dpi=190)


def _poses(path: Path) -> FloatArray | None:
    return read_tum(path)[1] if path.is_file() else None


def map_figure(contents: MapContents, colours: Palette = PAPER, longest: float = 9.0, bare: bool = False) -> Figure:
    """Draw the picture; at most ``longest`` inches wide. A ``bare`` one has neither title nor legend."""
    low, high = contents.extent
    across, up = high - low
    inches = (high - low) * min(longest / across, 0.7 * longest / up)
    size = figure_size(inches, (0.5 * longest, 0.18 * longest), (0.6, 0.9))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    plain_axes(axes, colours)
    draw_contents(axes, contents, colours)
    if bare:
        return figure
    if contents.truth is not None:
        axes.set_title(end_error_text(contents, contents.truth), fontsize="medium", color=colours.ink)
    columns = max(2, round(float(figure.get_figwidth()) / 1.7))
    figure.legend(
        loc="outside upper center", ncols=columns, fontsize="small", frameon=False, labelcolor=colours.ink,
        handlelength=1.8,
    )  # fmt: skip
    return figure


def end_error_text(contents: MapContents, truth: FloatArray) -> str:
    """Describe the distances of the ends of both trajectories from the true one."""
    ends = (path[min(len(path), len(truth)) - 1] for path in (contents.estimate, contents.odometry) if path is not None)
    ours, *off = (distance_text(float(np.hypot(*(end - truth[-1])[:2]))) for end in ends)
    return ", dead reckoning ".join([f"{contents.name} ends {ours} from the truth", *off])


def distance_text(metres: float) -> str:
    """Format a distance for people: 7.1 m, 3.4 cm."""
    return f"{metres:.1f} m" if metres >= 0.995 else f"{100 * metres:.1f} cm"
