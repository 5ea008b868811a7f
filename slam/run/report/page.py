"""The report: one HTML page that needs nothing but itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from slam.files.whole_files import write_whole
from slam.run.report.chapter import PERCENTILES, Chapter, chapter
from slam.run.report.inline_svg import THEMED, inline_svg
from slam.run.report.metric_rows import competes, rows
from slam.run.report.run_plots import distance_figure, iterations_figure, timing_figure
from slam.run.results.run_names import run_names
from slam.run.results.run_record import RunRecord


def write_report(records: Sequence[RunRecord], path: Path) -> None:
    """Write the page on these runs, one or more; several are compared."""
    names = run_names(records)
    chapters = [
        chapter(record, f"run{number}", name)
        for number, (record, name) in enumerate(zip(records, names, strict=True), 1)
    ]
    write_whole(path, _page(chapters, _overlays(records, names) if len(records) > 1 else []))


def _page(chapters: Sequence[Chapter], overlays: Sequence[tuple[Markup, str]]) -> str:
    environment = Environment(
        loader=PackageLoader("slam.run.report", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template("page.html").render(
        chapters=chapters,
        overlays=overlays,
        compared=rows([chapter.metrics for chapter in chapters]),
        competes=competes,
        rows=rows,
        percentiles=PERCENTILES,
    )


def _overlays(records: Sequence[RunRecord], names: Sequence[str]) -> list[tuple[Markup, str]]:
    """The curves of all runs on the same axes."""
    runs = [(f"{k}: {name}", record.traces) for k, (record, name) in enumerate(zip(records, names, strict=True), 1)]
    figures = (
        ("distance", distance_figure(runs, THEMED), "Position error over the way travelled."),
        ("iterations", iterations_figure(runs, THEMED), "Iterations of the matcher."),
        ("timing", timing_figure(runs, THEMED), "Processing time of the mapped scans."),
    )
    return [
        (inline_svg(figure, f"all-{name}", f"{name} of all runs: {caption}"), caption)
        for name, figure, caption in figures
        if figure is not None
    ]
