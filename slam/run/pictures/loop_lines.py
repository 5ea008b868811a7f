"""Loops as lines, from where a place was seen again to where it was seen first; doubtful ones dashed, with a cross."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from slam.graph.run_graph import RunGraph
from slam.pose import FloatArray
from slam.run.pictures.figure_style import Palette

NAMES: Final = "loop", "loop not believed"
_ABOVE: Final = 8


@dataclass(frozen=True, slots=True, eq=False)
class LoopLines:
    """L lines; metres, map frame."""

    ends: FloatArray
    """(L, 2, 2): ends of the lines."""
    believed: NDArray[np.bool_]
    """(L,): True for accepted loops."""

    @classmethod
    def of(cls, graph: RunGraph, poses: FloatArray) -> Self:
        """Make the lines of the loops of a graph, between poses (S, 3) of all scans of the run."""
        return cls(graph.loop_ends(poses), graph.believed)


def loops_until(graph: RunGraph, poses: FloatArray, scan: int) -> LoopLines:
    """Make the lines of the loops found up to a scan, between poses (S, 3) of all scans of the run."""
    found = np.array([loop.scan <= scan for loop in graph.loops], np.bool_)
    lines = LoopLines.of(graph, poses)
    return LoopLines(lines.ends[found], lines.believed[found])


def draw_loops(axes: Axes, loops: LoopLines, colours: Palette) -> None:
    """Draw the lines, with labels for a legend."""
    looks = (loops.believed, colours.loop, "-", "o"), (~loops.believed, colours.doubt, (0, (3, 2)), "X")
    for (which, colour, dash, mark), name in zip(looks, NAMES, strict=True):
        if not which.any():
            continue
        lines = LineCollection(list(loops.ends[which]), colors=colour, linewidths=1.5, linestyles=dash, zorder=_ABOVE)
        axes.add_collection(lines)
        axes.plot(
            *loops.ends[which].mean(axis=1).T, linestyle="none", marker=mark, color=colour, markersize=5,
            markeredgecolor="white", markeredgewidth=0.6, zorder=_ABOVE + 1, label=name,
        )  # fmt: skip
