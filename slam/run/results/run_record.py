"""Reads the folder of a run, finished or interrupted."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Self

from slam.errors import InputError
from slam.files.atomic_files import require_writable
from slam.files.graphs.file import read_graph
from slam.files.json_files import read_json
from slam.files.logs.read import RUN_LOG
from slam.files.maps.file import read_map
from slam.graph.run_graph import RunGraph
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D
from slam.robot import Observation
from slam.run.results.folder_update import finish_update
from slam.run.results.metric_table import metrics_fault
from slam.run.results.run_log import KnownMap, logged_known_map, logged_mount, logged_observations, logged_start
from slam.run.results.segment_file import read_segments
from slam.run.results.traces import Traces
from slam.saved_slam import SavedSlam
from slam.scenario.file import read_scenario
from slam.scenario.schema import Scenario

_SAME: Final = 1e-9
"""Metres and radians: two poses this near count as one."""


@dataclass(frozen=True, eq=False)
class RunRecord:
    """The results of a run; the larger parts are read on request."""

    folder: Path
    config: Scenario
    """Scenario of the run; for a replay, only ``slam`` and ``seed`` are its own."""
    traces: Traces
    """Stamps, the trajectories and the table of steps, scan by scan."""
    metrics: dict[str, Any] | None
    """Content of ``metrics.json``; None for an interrupted run."""
    damage: list[str] = field(default_factory=list)
    """A sentence for each damaged file, which was read up to the damage."""

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Read the folder of a run; InputError for another folder, and for a run without a scan.

        First puts new files in place if a command was killed before it could.
        """
        folder = Path(folder)
        with require_writable(folder, "it has new files to put in place; let it be changed"):
            finish_update(folder)
        if not (folder / "config.yaml").is_file():
            raise InputError(f"{folder}: {_fault(folder)}; give the folder of a run, such as runs/latest")
        traces = Traces.read(folder)
        if traces is None:
            raise InputError(f"{folder}: this run has no scan; give one that has at least one scan")
        config, metrics = read_scenario(folder / "config.yaml"), _metrics(folder / "metrics.json")
        return cls(folder, config, traces, metrics, list(traces.damage))

    @property
    def name(self) -> str:
        """Name of the folder, with links resolved."""
        return self.folder.resolve().name

    @property
    def complete(self) -> bool:
        """True for a run that ended by itself, and has metrics."""
        return self.metrics is not None

    @property
    def warnings(self) -> list[str]:
        """A sentence for the user on each damaged file."""
        return [f"{damage}; what comes after that is left out" for damage in self.damage]

    @property
    def outlines(self) -> list[FloatArray]:
        """True walls that the lidar could see, (K, 2) each, metres, map frame; empty for a replay."""
        return list(self.config.world.outlines(self.config.lidar.height))

    @cached_property
    def T_base_laser(self) -> Pose2D:
        """Mount of the lidar; InputError if the log does not have it."""
        return logged_mount(self.folder / RUN_LOG)

    @property
    def start(self) -> Pose2D:
        """``T_map_base`` before the first scan: exactly as set, if the log agrees except for rounding."""
        logged, given = logged_start(self.folder / RUN_LOG), self.config.robot.start.pose
        offset = given.between(logged)
        return given if offset.distance(Pose2D()) + abs(offset.theta) < _SAME else logged

    @property
    def known_map(self) -> KnownMap | None:
        """The saved map that it continued, also for an interrupted run."""
        return KnownMap.of(self.metrics or {}) or logged_known_map(self.folder / RUN_LOG)

    def observations(self) -> Iterator[Observation]:
        """Yield the observations of the robot, scan by scan, in the order of ``traces``; InputError without a log."""
        return logged_observations(self.folder / RUN_LOG)

    @cached_property
    def segments(self) -> tuple[IntArray, FloatArray]:
        """Segments of the mapped scans: the index of the scan of each, (M,), and its start and end, (M, 2, 2).

        Metres, map frame.
        """
        scans, ends, fault = read_segments(self.folder / "lines.geojson")
        if fault is not None:
            self.damage.append(fault)
        return scans, ends

    @cached_property
    def saved_map(self) -> SavedSlam | None:
        """Content of ``map.json``; None in paper mode, for an interrupted run, and if the map did not change."""
        path = self.folder / "map.json"
        again = self.folder / "closed.yaml"  # the settings of hopslam optimize, if they differ
        config = read_scenario(again) if again.is_file() else self.config
        return read_map(path, config.slam) if path.is_file() else None

    @cached_property
    def graph(self) -> RunGraph | None:
        """Content of ``graph.json``; None if no loops were closed at the end."""
        path = self.folder / "graph.json"
        return read_graph(path) if path.is_file() else None

    @property
    def walls(self) -> FloatArray:
        """The line map: start and end of each line, (M, 2, 2), metres, map frame.

        Without a saved map, every segment.
        """
        return self.segments[1] if self.saved_map is None else self.saved_map.mapper.map.ends


def _fault(folder: Path) -> str:
    if not folder.is_dir():
        return "not a folder" if folder.exists() else "no such folder"
    return "no run: it has no config.yaml"


def _metrics(path: Path) -> dict[str, Any] | None:
    if not path.exists():
        return None
    remedy = "remove it, and the run counts as cut off"
    metrics = read_json(path, remedy)
    if fault := metrics_fault(metrics):
        raise InputError(f"{path}: {fault}; {remedy}")
    known: dict[str, Any] = metrics
    return known
