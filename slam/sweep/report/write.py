"""Report of a sweep: ``report.html``, its tables and pictures, and a list of runs to examine."""

import base64
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Final

from jinja2 import Environment

from slam.console.result_table import ResultTable
from slam.errors import InputError, StorageError
from slam.run.results.metric_table import more_is_better
from slam.sweep.folder import Folder
from slam.sweep.lock import SweepLock
from slam.sweep.report.groups import RunGroup, group_runs, pick_metric
from slam.sweep.report.pictures import draw_bands, draw_boxes, draw_samples
from slam.sweep.report.tables import tables
from slam.sweep.result_store import RESULTS, ResultStore
from slam.sweep.sweep import CONFIG

_FOLDER: Final = "report"
_MAX_LISTED: Final = 10
"""Largest number of listed runs."""


@dataclass(frozen=True, slots=True)
class NotableRun:
    """A run to examine, and the reason."""

    id: str
    case: str
    reason: str
    command: str


@dataclass(frozen=True, slots=True)
class SweepReport:
    """Report of a sweep, with the address of its page."""

    page: str
    """Path or URL of ``report.html``."""
    tables: list[ResultTable]
    worst: list[NotableRun]
    failed: list[NotableRun]
    damage: list[str]
    """A sentence for each damaged file that was set aside; its runs are missing here."""


def write_report(out: str, metric: str | None = None) -> SweepReport:
    """Write tables, pictures and one page, from the results in ``out``, into its folder ``report``.

    InputError if there are none, or none has that metric. The report of a running sweep has the runs done so far.
    """
    folder = Folder(out)
    try:
        return _report_in(folder, out, metric)
    except OSError as error:
        raise StorageError(f"{out}: {error.strerror or error}; the results stay as they are") from error


def _report_in(folder: Folder, out: str, metric: str | None) -> SweepReport:
    if (config := folder.read(CONFIG)) is None:
        raise InputError(f"{out}: no sweep there; run: hopslam sweep SCENARIO --out {quote(out)}")
    store = ResultStore(folder)
    damage = list[str]()
    with suppress(InputError), SweepLock(folder):  # held by a running driver, which does this itself
        damage = store.set_damaged_aside()
        store.compact()
    metric = pick_metric(store, metric)
    groups = group_runs(store, metric)
    page = f"{(folder / _FOLDER).address}/report.html"
    report = SweepReport(page, tables(groups, metric), worst_runs(groups, metric), failed_runs(groups), damage)
    with folder.draft() as draft:
        here = draft / _FOLDER
        here.mkdir()
        pictures = _pictures(here, groups, metric)
        (here / "report.html").write_text(_page(report, pictures, config, folder), encoding="utf-8")
        folder.move_in(here, _FOLDER)
    return report


def worst_runs(groups: list[RunGroup], metric: str) -> list[NotableRun]:
    """Return the worst runs over all cases, the worst first: those with the largest values, unless more is better."""
    runs = [
        (value, NotableRun(run, f"{group.name}: {group.label}, seed {seed}", f"{metric} {value:.3g}", command))
        for group in groups
        for value, seed, (run, command) in zip(group.values, group.seeds, group.commands, strict=True)
    ]
    sign = 1.0 if more_is_better(metric) else -1.0
    return [run for _, run in sorted(runs, key=lambda run: sign * run[0])[:_MAX_LISTED]]


def failed_runs(groups: list[RunGroup]) -> list[NotableRun]:
    """Return the runs without a result, with their errors."""
    runs = [
        NotableRun(run, f"{group.name}: {group.label}", error, command)
        for group in groups
        for run, error, command in group.failures
    ]
    return runs[:_MAX_LISTED]


def _pictures(here: Path, groups: list[RunGroup], metric: str) -> list[Path]:
    """Draw the pictures for which there are data."""
    boxes, bands, samples = (here / f"{name}.png" for name in ("boxes", "bands", "samples"))
    draw_boxes(boxes, groups, metric)
    if any(group.curves for group in groups):
        draw_bands(bands, groups)
    if any(drawn for group in groups for drawn in group.drawn):
        draw_samples(samples, groups, metric)
    return [path for path in (boxes, bands, samples) if path.is_file()]


def _page(report: SweepReport, pictures: list[Path], config: str, folder: Folder) -> str:
    """Render the page: one self-contained file."""
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        Path(__file__).with_name("page.html").read_text(encoding="utf-8")
    )
    images = [{"name": path.stem, "data": base64.b64encode(path.read_bytes()).decode()} for path in pictures]
    name, results = folder.address.rstrip("/").rpartition("/")[2], f"{folder.address}/{RESULTS}"
    return str(template.render(report=report, name=name, images=images, config=config, results=results))
