"""The section of the page on one run."""

import os
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import version
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from slam.config import SlamConfig
from slam.graph.loop import Proposal
from slam.run.pictures.map_picture import contents_of, contents_without_loops, end_error_text, map_figure
from slam.run.report import run_plots
from slam.run.report.faults import faults
from slam.run.report.inline_svg import THEMED, inline_figures, inline_svg
from slam.run.report.run_plots import CAPTIONS, SIGMAS
from slam.run.results.metrics import measure
from slam.run.results.run_record import RunRecord
from slam.scenario.schema import Scenario

_LONGEST: Final = 60
"""Characters of a value; a longer list is shown by its length."""
_PROPOSALS: Final[dict[Proposal, str]] = {
    "odometry": "the graph", "walls": "the walls", "break": "the place of a break",
}  # fmt: skip
PERCENTILES = (50, 90, 99, 100)


@dataclass(frozen=True, slots=True)
class Change:
    """One setting that differs from its default."""

    key: str
    default: str
    value: str


def changes(scenario: Scenario) -> list[Change]:
    """Return the settings that differ from the defaults of the scenario's mode, in the order of the schema."""
    defaults = Scenario.model_validate({"name": scenario.name, "slam": {"mode": scenario.slam.mode}})
    given = SlamConfig().mode, scenario.slam.mode
    mode = [] if given[0] == given[1] else [Change("slam.mode", *given)]
    return mode + list(_differences(defaults.model_dump(mode="json"), scenario.model_dump(mode="json"), ""))


def _differences(default: Any, value: Any, key: str) -> Iterator[Change]:
    if isinstance(default, dict) and isinstance(value, dict):
        for name, inner in value.items():
            yield from _differences(default.get(name), inner, f"{key}.{name}" if key else name)
    elif default != value and key != "description":
        yield Change(key, _text(default), _text(value))


def _text(value: Any) -> str:
    text = "none" if value is None or value == [] else str(value)
    if len(text) <= _LONGEST:
        return text
    return f"{len(value)} entries" if isinstance(value, list | dict) else f"{text[:_LONGEST]} …"


@dataclass(frozen=True, slots=True)
class LoopRow:
    """Row of the table of loops."""

    found: str
    time: str
    agreement: str
    proposal: str
    weight: str
    believed: bool


@dataclass(frozen=True, slots=True)
class RunSection:
    """Text and pictures of one run on the page."""

    name: str
    """Unique on the page."""
    record: RunRecord
    date: str
    version: str
    ending: str
    metrics: Mapping[str, Any]
    faults: list[str]
    plots: list[tuple[Markup, str]]
    """Pictures with their captions; the map first."""
    timing: list[tuple[str, list[str]]]
    """Milliseconds at the PERCENTILES."""
    before: Markup | None
    """Map without loop closing; None if no loops were closed."""
    loops: list[LoopRow]
    """Loops, lowest weight first."""
    changes: list[Change]
    config_text: str
    command: str


def run_section(record: RunRecord, key: str, name: str) -> RunSection:
    """Make the section under this name; ``key`` is unique on the page."""
    metrics = measure(record.folder) if record.metrics is None else record.metrics
    return RunSection(
        name=name,
        record=record,
        date=_date(record, metrics),
        version=metrics.get("version", version("hopslam")),
        ending=metrics.get("ending", "cut off"),
        metrics=metrics,
        faults=faults(record, metrics),
        plots=_plots(record, key),
        timing=_timing(record),
        before=_before(record, key),
        loops=_loops(record),
        changes=changes(record.config),
        config_text=(record.folder / "config.yaml").read_text(encoding="utf-8"),
        command=command(record, metrics),
    )


def command(record: RunRecord, metrics: Mapping[str, Any]) -> str:
    """Return the shell command that repeats the run: the same settings, robot or log, and saved map."""
    config = str(record.folder / "config.yaml")
    verb = "localize" if "sure_after_s" in metrics else "replay" if "log" in metrics else "run"
    words = [verb, str(metrics["log"]), "--scenario", config] if "log" in metrics else [verb, config]
    options = {"--backend": "backend", "--map": "map", "--start": "start"}
    words += [word for option, key in options.items() if key in metrics for word in (option, str(metrics[key]))]
    return shlex.join(["hopslam", *words, *(["--dry-run"] if metrics.get("dry_run") else [])])


def _date(record: RunRecord, metrics: Mapping[str, Any]) -> str:
    """Return the date on which the run began; for an interrupted run, that of its settings."""
    if "began" in metrics:
        return datetime.fromisoformat(metrics["began"]).strftime("%Y-%m-%d %H:%M")
    written = os.stat(record.folder / "config.yaml").st_mtime  # noqa: PTH116
    return datetime.fromtimestamp(written).strftime("%Y-%m-%d %H:%M")


def _plots(record: RunRecord, key: str) -> list[tuple[Markup, str]]:
    traces, alone = record.traces, [("iterations", record.traces)]
    known = traces.truth is not None
    against = "Estimate less truth" if known else "Estimate less dead reckoning, as no truth is known"
    contents = contents_of(record)
    ends = "" if contents.truth is None else f" {end_error_text(contents, contents.truth)}."
    claimed = f" The band is ±{SIGMAS:g} standard deviations, as the estimate claims them."
    band = claimed if known and run_plots.has_variance(traces, "cov_xx") else ""
    figures = {
        "map": (map_figure(contents, THEMED, 8.4, bare=True), f"From above, metres.{ends}"),
        "errors": (run_plots.error_figure(traces, THEMED), f"{against}, scan by scan.{band}"),
        "distance": (run_plots.distance_figure([("", traces)], THEMED), CAPTIONS["distance"]),
        "iterations": (run_plots.iterations_figure(alone, THEMED), CAPTIONS["iterations"]),
        "timing": (run_plots.timing_figure(alone, THEMED), CAPTIONS["timing"]),
    }
    return inline_figures(figures, key)


def _before(record: RunRecord, key: str) -> Markup | None:
    contents = contents_without_loops(record)
    if contents is None or contents.loops is None or not len(contents.loops.ends):
        return None
    return inline_svg(map_figure(contents, THEMED, 8.4, bare=True), f"{key}-before", "map without loops")


def _loops(record: RunRecord) -> list[LoopRow]:
    graph, stamps = record.graph, record.traces.stamps
    if graph is None:
        return []
    rows = []
    for k in np.argsort(graph.weights, kind="stable").tolist():
        loop, (scan, _) = graph.loops[k], graph.loop_scans[k]
        if scan < 0:  # a loop of an earlier run
            continue
        rows.append(
            LoopRow(
                found=f"{loop.submap} in {loop.other}",
                time=f"{stamps[min(scan, len(stamps) - 1)] - stamps[0]:.1f}",
                agreement=f"{loop.agreeing} of {loop.tested}, {loop.share:.0%}"
                + ", one direction open" * loop.ambiguous,
                proposal=_PROPOSALS[loop.proposal],
                weight=f"{graph.weights[k]:.2f}",
                believed=bool(graph.believed[k]),
            )
        )
    return rows


def _timing(record: RunRecord) -> list[tuple[str, list[str]]]:
    mapped = record.traces.steps[record.traces.steps["mapped"] == 1]
    columns = {"line extraction": mapped["extraction_ms"], "all of SLAM": mapped["slam_ms"]}
    return [
        (name, [f"{value:.2f}" for value in np.percentile(column, PERCENTILES)])
        for name, column in columns.items()
        if len(column)
    ]
