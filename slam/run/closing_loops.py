"""Final loop closing at the end of a run, and its results."""

from array import array
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from slam.console.terminal import Terminal
from slam.errors import BackEndLost
from slam.files.graphs.file import write_graph
from slam.files.graphs.key_scans import write_key_scans
from slam.files.graphs.walls import write_walls
from slam.files.maps.file import write_map
from slam.files.tum import write_tum
from slam.graph.closure import ClosedRun
from slam.graph.mapped_walls import mapped_walls
from slam.graph.run_graph import RunGraph
from slam.line_slam import Estimate
from slam.pose import FloatArray
from slam.run.estimator import Estimator, finish, map_made_by
from slam.run.step import Step
from slam.saved_slam import SavedSlam


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoops:
    """A finished run with its closed loops."""

    run: ClosedRun
    graph: RunGraph
    saved: SavedSlam | None
    """State of the method in the closed map."""
    stamps: FloatArray
    """(S,): stamps of all scans, seconds."""
    trajectory: FloatArray
    """(S, 3): ``T_map_base`` at each scan."""
    seconds: float
    """Wall time of the final optimisation, seconds."""

    @property
    def metrics(self) -> dict[str, Any]:
        """Entries of ``metrics.json``."""
        believed = int(self.graph.believed.sum())
        return {"loops": len(self.graph.loops), "loops_believed": believed, "closing_s": round(self.seconds, 3)}

    def write(self, folder: Path) -> None:
        """Write the files of a closed run.

        They are ``map.json``, ``walls.geojson``, ``key_scans.npz``, ``graph.json`` and, last of all, ``closed.tum``: if
        that exists, all of them do.
        """
        if self.saved is not None:
            write_map(folder / "map.json", self.saved)
        write_walls(folder / "walls.geojson", mapped_walls(self.run))
        write_key_scans(folder / "key_scans.npz", self.run.keys)
        write_graph(folder / "graph.json", self.graph)
        write_tum(folder / "closed.tum", self.stamps, self.trajectory)


class LoopCloser:
    """Watcher that records the poses of the front end, and closes the loops at the end of the run."""

    def __init__(self, slam: Estimator) -> None:
        self._slam = slam
        self._rows = array("d")  # stamp, and x, y, theta of T_local_base, of all scans in a row
        self.back_end_lost = ""
        """One sentence on how and when the back end ended too early; empty if it did not."""

    @property
    def steps(self) -> int:
        """Number of scans so far."""
        return len(self._rows) // 4

    def on_step(self, step: Step) -> None:
        """Record one step."""
        self.add(step.estimate)

    def add(self, estimate: Estimate) -> None:
        """Record one estimate."""
        if estimate.back_end_lost and not self.back_end_lost:
            self.back_end_lost = f"{estimate.back_end_lost}; no loop is closed from scan {self.steps} on"
        local = estimate.T_local_base
        self._rows.extend((estimate.stamp, local.x, local.y, local.theta))

    def close_loops(self, console: Terminal) -> ClosedLoops | None:
        """Close the loops as ``closed`` does; None also if Ctrl-C interrupts it: the run then stays unchanged."""
        try:
            with console.waiting("closing loops"):
                return self.closed()
        except KeyboardInterrupt:
            return None

    def closed(self) -> ClosedLoops | None:
        """Close the loops.

        None for a method without loop closing, before the first scan, and if the back end has died.
        """
        if not self._rows:
            return None
        began, table = perf_counter(), np.array(self._rows).reshape(-1, 4)
        try:
            run = finish(self._slam)
        except BackEndLost as error:
            self.back_end_lost = self.back_end_lost or f"{error}; the run is not closed as a whole"
            return None
        if run is None:
            return None
        trajectory = run.trajectory(table[:, 1:])
        saved = map_made_by(self._slam, run)
        return ClosedLoops(run, RunGraph.of(run), saved, table[:, 0], trajectory, perf_counter() - began)
