"""Agreement of a scan with the view that the map predicts from a pose, compiled.

Facets without a matching wall are no evidence against a pose, as the robot may see a new area. Beams that should have
hit a wall of the map, and did not, are evidence against it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slam.compiled import compiled, compiled_on_views
from slam.mapping.free_beams import FreeBeams
from slam.mapping.free_space import cells_around
from slam.mapping.surfel_grid import NX, NY, Grid, X, Y
from slam.pose import FloatArray

TOLERANCE = 0.15  # metres across a wall within which a reading lies on it
EDGE_ON = 0.2  # least cosine of incidence at which a wall is predicted
HIDDEN_WEIGHT = 0.25  # weight of a beam that ends before the wall, against one that passed it
CORE = 0.5  # share of a surfel's width, about its middle, that is surely wall
MIN_PREDICTED = 0.1  # least share of the beams with a predicted wall
CLUSTER_WIDTH = 0.05  # metres to each side


class View(NamedTuple):
    """Three shares of the beams with a reading; for the remaining beams the map predicts no wall."""

    agreeing: float
    """Share that ends on the predicted wall."""
    through: float
    """Share that continues beyond it."""
    hidden: float
    """Share that ends before it."""

    @property
    def against(self) -> float:
        """Share that contradicts the pose.

        Beams that end early count less, as something new may stand before a wall.
        """
        return self.through + HIDDEN_WEIGHT * self.hidden

    @property
    def supported(self) -> float:
        """Share of the beams with a predicted wall that end on it; 1 if there are hardly any."""
        if self.agreeing + self.through + self.hidden < MIN_PREDICTED:
            return 1.0
        return self.agreeing / max(self.agreeing + self.against, 1e-9)


@compiled
def compare_view(grid: Grid, beams: FreeBeams, echoes: NDArray[np.bool_], pose: FloatArray, reach: float) -> View:
    """Compare the readings with the first wall of the map within ``reach`` along each beam from ``pose`` (3,).

    ``echoes`` (N,) is True for beams with an echo. Beams that only graze the end of a surfel are ignored: the wall may
    be shorter.
    """
    count = len(beams.ranges)
    nearest, across, surely = np.full(count, np.inf), np.zeros(count), np.zeros(count, np.bool_)
    low_row, high_row, low_column, high_column = cells_around(grid, pose, reach)
    for row in range(low_row, high_row):
        for column in range(low_column, high_column):
            k = grid.head[row, column]
            while k >= 0:
                _predict(grid.surfels[k], beams, pose, reach, 0.5 * grid.cell, nearest, across, surely)
                k = grid.next[k]
    readings = agreeing = through = hidden = 0
    for j in range(count):
        r = beams.ranges[j]
        if r <= 0.0:
            continue
        readings += 1
        if surely[j]:
            if echoes[j] and abs(r - nearest[j]) * across[j] < TOLERANCE:
                agreeing += 1
            elif r > nearest[j]:
                through += 1
            elif echoes[j]:
                hidden += 1
    return View(agreeing / max(readings, 1), through / max(readings, 1), hidden / max(readings, 1))


@compiled_on_views
def _predict(
    s: FloatArray, beams: FreeBeams, pose: FloatArray, reach: float, half: float, nearest: FloatArray,
    across: FloatArray, surely: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Predict a surfel as the wall for the beams that meet it, except where a nearer one is predicted already."""
    dx, dy = s[X] - pose[0], s[Y] - pose[1]
    distance = np.sqrt(dx * dx + dy * dy)
    if not half < distance < reach:
        return
    wall = s[NX] != 0.0 or s[NY] != 0.0
    cosine = (dx * s[NX] + dy * s[NY]) / distance if wall else 1.0
    if cosine < EDGE_ON:
        return
    width = half * cosine if wall else CLUSTER_WIDTH
    bearing = np.arctan2(dy, dx) - pose[2] - beams.angle_min
    bearing -= 2.0 * np.pi * np.floor(bearing / (2.0 * np.pi))
    middle, span = bearing / beams.angle_increment, width / distance / beams.angle_increment
    for j in range(max(int(np.ceil(middle - span)), 0), min(int(middle + span) + 1, len(nearest))):
        t = beams.angle_min + j * beams.angle_increment + pose[2]
        ux, uy = np.cos(t), np.sin(t)
        c = ux * s[NX] + uy * s[NY] if wall else 1.0
        if c < 0.5 * EDGE_ON:
            continue
        d = (dx * s[NX] + dy * s[NY]) / c if wall else distance
        if d < nearest[j]:
            nearest[j], across[j], surely[j] = d, c, abs(j - middle) < CORE * span
