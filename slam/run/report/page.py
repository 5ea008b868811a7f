"""The report: one self-contained HTML page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from slam.files.atomic_files import write_atomic
from slam.run.report.inline_svg import THEMED, inline_figures
from slam.run.report.run_plots import CAPTIONS, distance_figure, iterations_figure, timing_figure
from slam.run.report.run_section import PERCENTILES, RunSection, run_section
from slam.run.results.metric_table import METRICS, Metric
from slam.run.results.run_names import run_names
from slam.run.results.run_record import RunRecord

_COMPLETE: Final = {"arrived", "duration over", "no more scans"}
"""Endings of a run without failure."""


def write_report(records: Sequence[RunRecord], path: Path) -> None:
    """Write the page on these runs, one or more; several are compared."""
    names = run_names(records)
    sections = [
        run_section(record, f"run{number}", name)
        for number, (record, name) in enumerate(zip(records, names, strict=True), 1)
    ]
    write_atomic(path, _page(sections, _overlays(records, names) if len(records) > 1 else []))


def _page(sections: Sequence[RunSection], overlays: Sequence[tuple[Markup, str]]) -> str:
    environment = Environment(
        loader=PackageLoader("slam.run.report", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template("page.html").render(
        sections=sections,
        overlays=overlays,
        compared=metric_rows([section.metrics for section in sections]),
        is_comparable=is_comparable,
        metric_rows=metric_rows,
        percentiles=PERCENTILES,
    )


def _overlays(records: Sequence[RunRecord], names: Sequence[str]) -> list[tuple[Markup, str]]:
    """Draw the curves of all runs on the same axes."""
    runs = [(f"{k}: {name}", record.traces) for k, (record, name) in enumerate(zip(records, names, strict=True), 1)]
    figures = {
        "distance": (distance_figure(runs, THEMED), CAPTIONS["distance"]),
        "iterations": (iterations_figure(runs, THEMED), CAPTIONS["iterations"]),
        "timing": (timing_figure(runs, THEMED), CAPTIONS["timing"]),
    }
    return inline_figures(figures, "all", " of all runs")


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of a table: the text of its value, and whether it is the best in its row."""

    text: str
    best: bool = False


def metric_rows(runs: Sequence[Mapping[str, Any]]) -> list[tuple[Metric, list[Cell], list[Cell], list[Cell]]]:
    """Make a row for every metric that one of the runs has, with a cell for each run.

    Metrics of closed loops and of dead reckoning have their own rows; the best of several runs without failure is
    marked.
    """
    return [
        (metric, _cells(metric, runs), _others(metric, "closed", runs), _others(metric, "odometry", runs))
        for metric in METRICS.values()
        if any(metric.key in run for run in runs)
    ]


def is_comparable(run: Mapping[str, Any]) -> bool:
    """Return True for a run that was completed.

    A run that was cut short is not compared: its shorter path would have smaller errors.
    """
    return run.get("ending") in _COMPLETE


def _cells(metric: Metric, runs: Sequence[Mapping[str, Any]]) -> list[Cell]:
    texts = [metric.shown(run.get(metric.key)) for run in runs]
    rivals = [run[metric.key] for run in runs if is_comparable(run) and run.get(metric.key) is not None]
    best = _best(metric, rivals) if len(rivals) > 1 else None
    apart = len({metric.shown(value) for value in rivals}) > 1
    return [Cell(text, apart and is_comparable(run) and text == best) for text, run in zip(texts, runs, strict=True)]


def _best(metric: Metric, values: Sequence[Any]) -> str | None:
    """Return the best value in the form of the table; None if none is better than another."""
    if not metric.less_is_better and not metric.more_is_better:
        return None
    return metric.shown(min(values) if metric.less_is_better else max(values))


def _others(metric: Metric, prefix: str, runs: Sequence[Mapping[str, Any]]) -> list[Cell]:
    values = [run.get(f"{prefix}_{metric.key}") for run in runs]
    return [Cell("" if value is None else metric.shown(value)) for value in values]
