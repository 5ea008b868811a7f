"""The map of this project: surfels, short pieces of wall with the side from which they were seen.

It grows with the seen area and not with time: a cell has one surfel for each side of each wall in it.
"""

from math import floor

import numpy as np

from slam.config import SurfelMapConfig
from slam.mapping.free_beams import FreeBeams, free_beams
from slam.mapping.free_space import carve
from slam.mapping.surfel_grid import ALIVE, HITS, TAKEN, Grid, empty_grid, room_needed, with_room
from slam.mapping.surfel_updates import put
from slam.mapping.wall_evidence import weigh_walls
from slam.mapping.wall_segments import wall_segments
from slam.pose import FloatArray, Pose2D
from slam.scan import LaserScan

WEIGHED_EVERY = 0.1
"""Path length between two scans that add evidence of walls, the sum of metres and radians; the scans between them are
redundant."""


class SurfelMap:
    """Surfels in a grid; ``ends`` are the walls that they form."""

    def __init__(self, config: SurfelMapConfig, grid: Grid | None = None) -> None:
        self.config = config
        self.grid = grid or empty_grid(config.cell)

    def __len__(self) -> int:
        """Number of surfels."""
        return int(self.grid.counts[ALIVE])

    @property
    def surfels(self) -> FloatArray:
        """The surfels alive, with the columns of surfel_grid.py, shape (S, 8), map frame."""
        taken = self.grid.surfels[: self.grid.counts[TAKEN]]
        return taken[taken[:, HITS] > 0.0]

    @property
    def points(self) -> FloatArray:
        """Centres of the surfels, shape (S, 2), metres, map frame."""
        return self.surfels[:, :2]

    @property
    def ends(self) -> FloatArray:
        """Start and end of every wall, shape (M, 2, 2): [wall, start or end, x or y]; metres, map frame."""
        taken = int(self.grid.counts[TAKEN])
        alive = self.grid.surfels[:taken, HITS] > 0.0
        return wall_segments(self.grid.surfels[:taken][alive], self.grid.evidence[:taken][alive], self.config.cell)

    @property
    def nbytes(self) -> int:
        """Memory of the map, bytes."""
        return sum(array.nbytes for array in self.grid if isinstance(array, np.ndarray))

    def add(
        self, facets: FloatArray, scan: LaserScan, T_map_laser: Pose2D, moved: float = 0.0, walls: bool = True
    ) -> None:
        """Add the facets (F, 7) of a scan to the map, and count misses of surfels that its beams passed.

        The arguments are those of ``write``.
        """
        self.write(facets, free_beams(scan, self.config.no_echo_reach), T_map_laser, moved, walls)

    def write(
        self, facets: FloatArray, beams: FreeBeams, T_map_laser: Pose2D, moved: float = 0.0, walls: bool = True
    ) -> None:
        """Add facets (F, 7) to the map, and count misses of surfels that the beams of their scan passed.

        ``moved`` is the motion of the sensor since the previous scan, the sum of metres and radians. ``walls`` is True
        if the beams add evidence of walls; a map whose ``ends`` are not used needs none.
        """
        config, pose = self.config, T_map_laser.as_array()
        before, length = self.grid.path_length, self.grid.path_length + moved
        self.grid = self.grid._replace(path_length=length)
        if len(facets):
            self.grid = with_room(self.grid, *room_needed(facets, pose, config.cell))
            put(self.grid, facets, pose, config.gate, float(config.max_hits), config.pose_sigma)
        if walls and (moved == 0.0 or floor(length / WEIGHED_EVERY) > floor(before / WEIGHED_EVERY)):
            weigh_walls(self.grid, beams, pose, config.carve_reach, config.gate)
        carve(self.grid, beams, pose, config.carve_reach, config.free_margin, config.miss_ratio)
