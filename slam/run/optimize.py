"""Closes the loops of a finished run again, possibly with other settings, from the files in its folder."""

import json
import shutil
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any, Final

from slam.console.terminal import Terminal
from slam.errors import InputError
from slam.files.atomic_files import write_atomic
from slam.files.links import link_file
from slam.graph.loop_closing import STEPPED, Timing
from slam.odometry import Twist2D
from slam.run.closing_loops import ClosedLoops, LoopCloser
from slam.run.estimator import make_estimator
from slam.run.results.folder_update import folder_update
from slam.run.results.metrics import measure
from slam.run.results.run_folder import make_run_folder
from slam.run.results.run_record import RunRecord
from slam.run.results.traces import carried_on
from slam.run.scoring.seen_walls import SeenWalls
from slam.run.scoring.wall_score import score_walls, wall_metrics
from slam.run.step import Step
from slam.scenario.file import dump_scenario
from slam.scenario.schema import Scenario

KEPT: Final = (
    "config.yaml", "log.mcap", "trajectory.tum", "odometry.tum", "groundtruth.tum", "steps.csv", "lines.geojson",
)  # fmt: skip
"""Files of the results during the run, which do not change."""


@dataclass(frozen=True, slots=True)
class Optimization:
    """Closes the loops of a run again with the settings of a scenario."""

    record: RunRecord
    scenario: Scenario
    changed: list[str] = field(default_factory=list)
    """The settings that differ from the run's own, as they were given."""

    def run(self, out: Path | None, console: Terminal) -> tuple[Path, dict[str, Any]]:
        """Optimise, in the folder of the run or in a new one; return the folder and its metrics.

        All new files are put in place together; ``run.rrd``, which shows the old ones, is removed. Scans that are
        missing in the log are placed by the motion from the last one before. InputError for a run without loops.
        """
        record = self.record
        if known := record.known_map:
            raise InputError(
                f"{record.folder}: it continued the map {known.map}, whose scans are not in its log; close its loops "
                f"again with hopslam replay {record.folder} --map {known.map} --start {known.start}"
            )
        closed, walls = self._close(console)
        folder = record.folder if out is None else _copied(record.folder, make_run_folder(record.config.name, out))
        with folder_update(folder, outdated=("closed.yaml", "run.rrd")) as draft:
            _link_kept(folder, draft)
            closed.write(draft)
            metrics = (record.metrics or {}) | measure(draft) | closed.metrics | walls
            for outdated in ("optimized", "back_end_lost"):
                metrics.pop(outdated, None)
            if self.changed:
                write_atomic(draft / "closed.yaml", dump_scenario(self.scenario))
                metrics["optimized"] = self.changed
            if record.complete:
                write_atomic(draft / "metrics.json", json.dumps(metrics, indent=2) + "\n")
            self._draw(draft, closed, console)
        return folder, metrics

    @property
    def _timing(self) -> Timing:
        """When closures are applied: at the same scans as in the run, unless the settings were changed."""
        closures = self.record.traces.closures
        return STEPPED if self.changed or closures is None else Timing(known=closures)

    def _close(self, console: Terminal) -> tuple[ClosedLoops, dict[str, Any]]:
        """Run the front end over the log again, and close the loops; also return the score of the walls."""
        record = self.record
        start, seed = record.start, record.config.seed
        slam = make_estimator(self.scenario.slam, record.T_base_laser, start, seed, self._timing)
        closer, seen = LoopCloser(slam), SeenWalls(record.outlines, record.T_base_laser)
        with console.progress(transient=True) as bar:
            total = len(record.traces.stamps)
            scans = islice(record.observations(), total)
            for index, observation in enumerate(bar.track(scans, total, description="matching the scans again")):
                step = Step(index, observation, slam.update(observation.scan, observation.odometry), Twist2D(), 0.0)
                closer.on_step(step)
                seen.on_step(step)
        closed = closer.close_loops(console)
        if closed is None:
            raise InputError(
                f"{record.folder}: no loops are closed by these settings; add --set slam.loops=auto, in mode hopslam"
            )
        closed = _for_all_scans(closed, record)
        if not seen.scans.any():
            return closed, {}
        return closed, wall_metrics(score_walls(seen.walls, seen.seen, closed.run.map.ends))

    def _draw(self, folder: Path, closed: ClosedLoops, console: Terminal) -> None:
        from slam.run.pictures.error_curves import draw_errors  # imported here, as matplotlib loads slowly
        from slam.run.pictures.map_picture import draw_map

        with console.waiting("drawing"):
            draw_map(folder, closed.run.map.points, closed.run.map.ends, self.record.outlines)
            draw_errors(folder)


def _copied(folder: Path, out: Path) -> Path:
    """Make the new folder with the files that do not change."""
    for name in KEPT:
        if (folder / name).is_file():
            shutil.copyfile(folder / name, out / name)
    return out


def _link_kept(folder: Path, draft: Path) -> None:
    """Link the unchanged files beside the new ones, for reading."""
    draft.mkdir()
    for name in KEPT:
        if (folder / name).is_file():
            link_file(folder / name, draft / name)


def _for_all_scans(closed: ClosedLoops, record: RunRecord) -> ClosedLoops:
    """Return the closed run with a pose for each scan, including those missing in the log of a killed run."""
    stamps, estimate = record.traces.stamps, record.traces.estimate
    if len(closed.stamps) == len(stamps):
        return closed
    return replace(closed, stamps=stamps, trajectory=carried_on(closed.stamps, closed.trajectory, stamps, estimate))
