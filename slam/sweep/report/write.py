"""``report.html`` and its pictures."""

from __future__ import annotations

import base64
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

import yaml
from jinja2 import Environment

from slam.console.result_table import ResultTable
from slam.errors import InputError
from slam.sweep.folder import Folder
from slam.sweep.lock import Lock
from slam.sweep.report.groups import Group, grouped, pick_metric
from slam.sweep.report.pictures import draw_bands, draw_boxes, draw_samples
from slam.sweep.report.tables import tables
from slam.sweep.report.worst import NamedRun, failed_runs, worst_runs
from slam.sweep.store import RESULTS, SweepStore
from slam.sweep.sweep import CONFIG

_FOLDER = "report"


@dataclass(frozen=True, slots=True)
class Report:
    """What was made."""

    page: str
    """Where ``report.html`` is."""
    tables: list[ResultTable]
    worst: list[NamedRun]
    failed: list[NamedRun]


def write_report(out: str, metric: str | None = None) -> Report:
    """Tables, pictures and one page, from the results in ``out``, into its folder ``report``.

    InputError where there are none, or none has that metric. A sweep that runs is reported as far as it is.
    """
    folder = Folder(out)
    if (config := folder.read(CONFIG)) is None:
        raise InputError(f"{out}: no sweep there; run: hopslam sweep SCENARIO --out {quote(out)}")
    store = SweepStore(folder)
    with suppress(InputError), Lock(folder):  # held by a driver at work, which does this itself
        store.compact()
    metric = pick_metric(store, metric)
    groups = grouped(store, metric)
    page = f"{(folder / _FOLDER).address}/report.html"
    report = Report(page, tables(groups, metric), worst_runs(groups, metric), failed_runs(groups))
    with folder.draft() as draft:
        here = draft / _FOLDER
        here.mkdir()
        pictures = _pictures(here, groups, metric)
        (here / "report.html").write_text(_page(report, pictures, config, folder), encoding="utf-8")
        folder.take_in(here, _FOLDER)
    return report


def _pictures(here: Path, groups: list[Group], metric: str) -> list[Path]:
    """Those for which there is something to draw."""
    boxes, bands, samples = (here / f"{name}.png" for name in ("boxes", "bands", "samples"))
    draw_boxes(boxes, groups, metric)
    if any(group.curves for group in groups):
        draw_bands(bands, groups)
    if any(drawn for group in groups for drawn in group.drawn):
        draw_samples(samples, groups, metric)
    return [path for path in (boxes, bands, samples) if path.is_file()]


def _page(report: Report, pictures: list[Path], config: str, folder: Folder) -> str:
    """One file that needs no other."""
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        Path(__file__).with_name("page.html").read_text(encoding="utf-8")
    )
    images = [{"name": path.stem, "data": base64.b64encode(path.read_bytes()).decode()} for path in pictures]
    return str(
        template.render(
            report=report,
            name=yaml.safe_load(config)["name"],
            images=images,
            config=config,
            results=f"{folder.address}/{RESULTS}",
        )
    )
