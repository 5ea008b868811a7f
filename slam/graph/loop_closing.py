"""Loop closing during a run: key scans are sent to the back end, and its closures are applied at known scans."""

from collections import deque
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Final, Self

from slam.errors import BackEndLost
from slam.graph.back_end import BackEnd
from slam.graph.back_end_process import BackEndProcess
from slam.graph.closed_map import ClosedMap
from slam.graph.closure import ClosedRun, Closure
from slam.graph.graph_size import GraphSize
from slam.graph.key_scan import KeyScan
from slam.graph.known_graph import KnownGraph
from slam.graph.map_tracking import MapTracking
from slam.graph.single_poses import composed
from slam.graph.submap_mapper import SubmapMapper
from slam.mapping.surfel_map import SurfelMap
from slam.pose import FloatArray, Pose2D

DELAY: Final = 10
"""Scans from the end of a submap to the application of its closure in a stepped run."""
ALONE_UNTIL: Final = 4
"""Number of finished submaps before the process is started (one if an earlier graph is known): until then there is
nothing to close."""


@dataclass(frozen=True, slots=True)
class Timing:
    """Rule for the scan at which closures are applied.

    A stepped run applies each at a fixed later scan, and waits for it there, so that the result does not depend on the
    speed of the machine. A run in real time never waits. A repetition applies each at the scan where the original run
    did.
    """

    real_time: bool = False
    known: Mapping[int, int] | None = None
    """Number of the submap whose closure is applied, by scan index, as in the original run."""


STEPPED: Final = Timing()
"""Rule of a stepped run."""


class LoopClosing:
    """The globally consistent map so far, and the pose of the frame ``local`` in it."""

    def __init__(self, mapper: SubmapMapper, timing: Timing, known: KnownGraph | None = None) -> None:
        self.T_map_local = Pose2D()
        self._mapper, self._timing, self._graph = mapper, timing, known
        self._closed = ClosedMap(SurfelMap(mapper.map.config) if known is None else deepcopy(mapper.map))
        self._tracking = MapTracking(mapper.config, mapper.map.config)
        self._process: BackEndProcess | None = None
        self._early: list[KeyScan] = []  # not yet sent to the process
        self._since: deque[KeyScan] = deque()  # key scans that the next closure may lack
        self._known = 0 if known is None else len(known.keys)  # number of key scans before the first of ``_since``
        self._jobs: deque[tuple[int, int]] = deque()  # submaps being searched, and the scan at which the result is due
        self._submap = mapper.number  # number of the submap of the last key scan
        self.waited = 0.0
        """Seconds that the last ``follow`` waited for the back end, as a stepped run does."""
        self.back_end_lost = ""
        """Description of how the back end ended too early; from then on no loop is closed. Empty while it runs."""

    @classmethod
    def for_mapper(cls, mapper: object, timing: Timing = STEPPED, known: KnownGraph | None = None) -> Self | None:
        """Make the loop closing of a mapper: loops within the run, and with the graph of the map that it continues.

        None for a mapper that makes no submaps.
        """
        return cls(mapper, timing, known) if isinstance(mapper, SubmapMapper) else None

    @property
    def map(self) -> SurfelMap:
        """The map of all key scans."""
        return self._closed.map

    @property
    def size(self) -> GraphSize:
        """Size of the graph at the last result."""
        return self._process.size if self._process is not None else GraphSize(len(self._early))

    def follow(self, index: int) -> Closure | None:
        """Process scan ``index`` of the run, if it became a key scan.

        Returns the closure that is applied now, if there is one.
        """
        if self._mapper.key is not None:
            self._take(replace(self._mapper.key, index=index), index)
        began, closure = perf_counter(), None
        try:
            closure = self._closure_at(index)
        except BackEndLost as error:
            self._go_on_alone(error)
        self.waited = perf_counter() - began
        if closure is not None:
            self._take_over(closure)
        return closure

    def finish(self, T_base_laser: Pose2D) -> ClosedRun | None:
        """Return the whole run, refined, after the last key scan; this object then has its map.

        None if no scan came; BackEndLost if the back end has ended.
        """
        if self.back_end_lost:
            raise BackEndLost(self.back_end_lost)
        run = self._finished(T_base_laser.as_array())
        if run is not None:
            self.T_map_local, self._closed = Pose2D.from_array(run.T_map_local), ClosedMap(run.map)
        return run

    def _finished(self, T_base_laser: FloatArray) -> ClosedRun | None:
        if self._process is not None:
            return self._process.finish(T_base_laser)
        if not self._early:
            return None
        back_end = BackEnd(self._mapper.config, self._mapper.map.config, self._graph)
        for key in self._early:
            back_end.take(key)
        return back_end.finish(T_base_laser)

    def _take(self, key: KeyScan, index: int) -> None:
        """Send a key scan to the back end, and add it to the map at its estimated pose."""
        if not self.back_end_lost:
            self._send(key, index)
        self._add(key)

    def _send(self, key: KeyScan, index: int) -> None:
        finished, self._submap = self._submap, key.submaps[0]
        if self._process is None:
            self._early.append(key)
        else:
            self._process.send(key)
        if key.submaps[0] > finished:
            self._jobs.append((finished, index + DELAY))
        self._since.append(key)
        if self._process is None and len(self._jobs) == (ALONE_UNTIL if self._graph is None else 1):
            self._start()

    def _start(self) -> None:
        try:
            self._process = BackEndProcess(self._mapper.config, self._mapper.map.config, self._early, self._graph)
        except BackEndLost as error:
            self._go_on_alone(error)
        self._early = []

    def _go_on_alone(self, error: BackEndLost) -> None:
        self.back_end_lost = str(error)
        self._jobs.clear()
        self._since.clear()

    def _closure_at(self, index: int) -> Closure | None:
        """Return the closure to apply at this scan, if any."""
        closure = None
        while self._process is not None and self._jobs and self._is_due(*self._jobs[0], index):
            known, result = self._process.next_result(wait=not self._timing.real_time)
            if not known:
                break
            self._jobs.popleft()
            closure = result or closure
        return closure

    def _is_due(self, submap: int, scan: int, index: int) -> bool:
        """Return True if the result for a submap is due at this scan."""
        if self._timing.real_time:
            return True
        if self._timing.known is None:
            return index >= scan
        return index in self._timing.known and submap <= self._timing.known[index]

    def _take_over(self, closure: Closure) -> None:
        self.T_map_local = Pose2D.from_array(closure.T_map_local)
        self._mapper.set_covariance(closure.T_local_submap, closure.covariance, self.T_map_local)
        self._closed = ClosedMap(closure.map)
        self._tracking.restart()
        while self._known < closure.keys:
            self._since.popleft()
            self._known += 1
        for key in self._since:
            self._add(key)

    def _add(self, key: KeyScan) -> None:
        """Find a key scan in the map, and add it there."""
        T_map_local, known = self._tracking.follow(key, self.T_map_local.as_array(), self.map.grid)
        self.T_map_local = Pose2D.from_array(T_map_local)
        for one in known:
            self._closed.add(one, composed(T_map_local, one.T_local_laser))
