"""A finished run as a value: its outcome, its folder, its data and pictures."""

from base64 import b64encode
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from signal import SIGINT
from typing import Any, Self

from slam.console.result_table import ResultTable
from slam.errors import HopslamError
from slam.files.logs import Loss
from slam.pose import FloatArray
from slam.run.experiment import Outcome
from slam.run.results.metric_table import METRICS
from slam.run.results.metrics import measure
from slam.run.results.run_record import RunRecord

_SHOWN: frozenset[str] = frozenset(
    {"ate_rmse_m", "ate_max_m", "final_m", "heading_rmse_deg", "loops_believed", "scans", "path_m", "duration_s"}
)


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run, and its folder. Poses are rows x, y, theta of the robot in the map, metres and radians."""

    folder: Path
    ending: str | None
    """Reason why it ended, such as ``arrived``; None for a run that was killed."""
    metrics: dict[str, Any]
    """Content of ``metrics.json``; slam/run/results/metric_table.py says what each number is."""
    error: HopslamError | None = None
    """Error of a run that failed."""
    loss: Loss | None = None
    """Scans of the recorded log that could not be used."""
    signal: int = SIGINT
    """Number of the signal that interrupted it, if one did."""

    @classmethod
    def of(cls, outcome: Outcome, loss: Loss | None) -> Self:
        """Make the run with this outcome."""
        return cls(outcome.folder, outcome.ending, outcome.metrics, outcome.error, loss, outcome.signal)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Read the folder of a run; InputError for another folder, and for a run without a scan."""
        record = RunRecord.open(folder)
        metrics = measure(record.folder) if record.metrics is None else record.metrics
        return cls(record.folder, metrics.get("ending"), metrics)

    def require_success(self, lenient: bool = False) -> None:
        """Raise the error of a run that did not end properly.

        Raises the error with which it failed, KeyboardInterrupt if it was interrupted, and ScansLost if most scans of
        the log were lost, unless ``lenient``.
        """
        if self.error is not None:
            self.error.add_note(f"what was done is in {self.folder}")
            raise self.error
        if self.ending == "interrupted":
            raise KeyboardInterrupt(f"what was done is in {self.folder}")
        if self.loss is not None:
            self.loss.require_most(lenient)

    @property
    def warnings(self) -> list[str]:
        """A sentence for the user on each loss, and what to do about it."""
        sentences = []
        if self.loss is not None and self.loss.warning:
            sentences.append(f"{self.loss.warning}: {self.loss.report}")
        if "back_end_lost" in self.metrics:
            sentences.append(f"{self.metrics['back_end_lost']}; close its loops with hopslam optimize {self.folder}")
        return sentences

    @cached_property
    def record(self) -> RunRecord:
        """All results, in the form of the package ``slam``, which is not part of the stable API."""
        return RunRecord.open(self.folder)

    @property
    def stamps(self) -> FloatArray:
        """Stamp of each scan, (K,), seconds."""
        return self.record.traces.stamps

    @property
    def trajectory(self) -> FloatArray:
        """Final pose of the robot at each scan, (K, 3), after loop closing."""
        return self.record.traces.final

    @property
    def estimate(self) -> FloatArray:
        """Pose of the robot as estimated at each scan, (K, 3)."""
        return self.record.traces.estimate

    @property
    def odometry(self) -> FloatArray:
        """Pose of the robot by its wheels alone, (K, 3)."""
        return self.record.traces.odometry

    @property
    def truth(self) -> FloatArray | None:
        """True pose of the robot, (K, 3); None if unknown."""
        return self.record.traces.truth

    @property
    def walls(self) -> FloatArray:
        """Start and end of each wall of the map, (N, 2, 2), metres, map frame."""
        return self.record.walls

    def export(self, to: str, out: str | Path, force: bool = False) -> None:
        """Write the run in another format, such as ``tum`` or ``ros``: ``hopslam export --help`` lists them."""
        from slam.run.export.formats import export

        export(self.record, to, Path(out), force)

    def report(self, path: str | Path) -> Path:
        """Write the report, one self-contained HTML page, and return its path."""
        from slam.run.report.page import write_report

        write_report([self.record], Path(path))
        return Path(path)

    def view(self, width: int = 950, height: int = 600) -> Any:
        """Show the run in rerun's viewer, a widget for notebooks; ``hopslam view`` opens a window.

        InputError if rerun-notebook is not installed.
        """
        from slam.run.viewer.finished_run import notebook_viewer, recording_of

        return notebook_viewer(recording_of(self.folder, lambda scans, _: scans), width, height)

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r}, {self.ending or 'cut off'}, {self.metrics['scans']} scans)"

    def picture(self) -> bytes | None:
        """Draw the map, with the true walls and three trajectories.

        Return the content of a PNG file, None without a scan.
        """
        if not self.metrics["scans"]:
            return None
        from slam.run.pictures.figure_style import png_of
        from slam.run.pictures.map_picture import contents_of, map_figure

        return png_of(map_figure(contents_of(self.record), longest=9.0))

    def _repr_png_(self) -> bytes | None:
        return self.picture()

    def _repr_html_(self) -> str:
        """Show the main metrics above the map."""
        rows = [
            (METRICS[key].name, METRICS[key].shown(self.metrics[key]), METRICS[key].unit)
            for key in METRICS
            if key in _SHOWN and self.metrics.get(key) is not None
        ]
        table = ResultTable(f"{self.folder}: {self.ending or 'cut off'}", ("", "", ""), rows).html()
        if (picture := self.picture()) is None:
            return table
        return f'{table}<img src="data:image/png;base64,{b64encode(picture).decode()}" alt="map">'
