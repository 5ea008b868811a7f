"""Loops closed beside the front end: key scans go out, closures come back and are taken over at a known scan."""

from dataclasses import replace
from typing import Final, Self

from slam.graph.back_end import BackEnd
from slam.graph.closed_map import ClosedMap
from slam.graph.closure import ClosedRun, Closure
from slam.graph.key_scan import KeyScan
from slam.graph.submap_mapper import SubmapMapper
from slam.mapping.surfel_map import SurfelMap
from slam.pose import Pose2D, compose_poses

DELAY: Final = 10
"""Scans after a submap is finished, until which its loops must be found."""


class LoopClosing:
    """The map that is right as a whole, as far as it is known, and where the frame ``local`` lies in it."""

    def __init__(self, mapper: SubmapMapper) -> None:
        self.T_map_local = Pose2D()
        self._mapper, config = mapper, mapper.state.map.config
        self._closed = ClosedMap(SurfelMap(config))
        self._back_end = BackEnd(mapper.config, config)
        self._since: list[KeyScan] = []  # key scans that the next closure may not know

    @classmethod
    def beside(cls, mapper: object) -> Self | None:
        """Loops for this mapper; None for one that makes no submaps."""
        return cls(mapper) if isinstance(mapper, SubmapMapper) else None

    @property
    def map(self) -> SurfelMap:
        """The map of all key scans."""
        return self._closed.map

    def follow(self, index: int) -> Closure | None:
        """Take the last scan, number ``index`` of the run, where it became a key scan; returns the closure that is
        taken over now, if one is."""
        if self._mapper.key is None:
            return None
        key = replace(self._mapper.key, index=index)
        closure = self._back_end.take(key)
        self._since.append(key)
        if closure is not None:
            self._take_over(closure)
        else:
            self._add(key)
        return closure

    def finish(self, T_base_laser: Pose2D) -> ClosedRun:
        """The whole run, refined; there are no more key scans."""
        return self._back_end.finish(T_base_laser.as_array())

    def _take_over(self, closure: Closure) -> None:
        self.T_map_local = Pose2D.from_array(closure.T_map_local)
        self._closed = ClosedMap(closure.map)
        for key in self._since[closure.keys - len(self._since) :]:
            self._add(key)

    def _add(self, key: KeyScan) -> None:
        self._closed.add(key, compose_poses(self.T_map_local.as_array(), key.T_local_laser))
