"""One run as the page shows it."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import version
from typing import Any

import numpy as np
from markupsafe import Markup

from slam.run.pictures.map_picture import Plan, map_figure, where_it_ends
from slam.run.report.faults import faults
from slam.run.report.inline_svg import THEMED, inline_svg
from slam.run.report.run_plots import (
    SIGMAS,
    distance_figure,
    error_figure,
    iterations_figure,
    timing_figure,
)
from slam.run.report.settings import Change, changes
from slam.run.results.metrics import measure
from slam.run.results.run_record import RunRecord

PERCENTILES = (50, 90, 99, 100)


@dataclass(frozen=True, slots=True)
class Chapter:
    """All of it as text and pictures."""

    name: str
    """Unlike that of any other run of the page."""
    description: str
    folder: str
    date: str
    version: str
    ending: str
    metrics: Mapping[str, Any]
    faults: list[str]
    log_report: str
    outlined: bool
    """Whether the true walls are known ..."""
    truth_known: bool
    """... and the true way."""
    plots: list[tuple[Markup, str]]
    """Each with its caption; the map first."""
    timing: list[tuple[str, list[str]]]
    """Milliseconds at the PERCENTILES."""
    changes: list[Change]
    config: str
    command: str


def chapter(record: RunRecord, key: str, name: str) -> Chapter:
    """The chapter under this name; ``key`` is its own on the page."""
    metrics = measure(record.folder) if record.metrics is None else record.metrics
    return Chapter(
        name=name,
        description=record.config.description,
        folder=str(record.folder),
        date=_date(record, metrics),
        version=metrics.get("version", version("hopslam")),
        ending=metrics.get("ending", "cut off"),
        metrics=metrics,
        faults=faults(record, metrics),
        log_report=str(metrics.get("log_report", "")),
        outlined=bool(record.outlines),
        truth_known=record.traces.truth is not None,
        plots=_plots(record, key),
        timing=_timing(record),
        changes=changes(record.config),
        config=(record.folder / "config.yaml").read_text(encoding="utf-8"),
        command=command(record, metrics),
    )


def plan_of(record: RunRecord) -> Plan:
    """What the run mapped."""
    traces = record.traces
    return Plan(record.walls, traces.estimate, traces.odometry, traces.truth, record.outlines)


def command(record: RunRecord, metrics: Mapping[str, Any]) -> str:
    """What repeats the run, for a shell: with the same settings, on the same robot or log, in the same saved map."""
    config = str(record.folder / "config.yaml")
    verb = "localize" if "sure_after_s" in metrics else "replay" if "log" in metrics else "run"
    words = [verb, str(metrics["log"]), "--scenario", config] if "log" in metrics else [verb, config]
    options = {"--backend": "backend", "--map": "map", "--start": "start"}
    words += [word for option, key in options.items() if key in metrics for word in (option, str(metrics[key]))]
    return shlex.join(["hopslam", *words, *(["--dry-run"] if metrics.get("dry_run") else [])])


def _date(record: RunRecord, metrics: Mapping[str, Any]) -> str:
    """When the run began; of one that was cut off, when its settings were written."""
    if "began" in metrics:
        return datetime.fromisoformat(metrics["began"]).strftime("%Y-%m-%d %H:%M")
    written = os.stat(record.folder / "config.yaml").st_mtime  # noqa: PTH116
    return datetime.fromtimestamp(written).strftime("%Y-%m-%d %H:%M")


def _plots(record: RunRecord, key: str) -> list[tuple[Markup, str]]:
    traces, alone = record.traces, [("iterations", record.traces)]
    known = traces.truth is not None
    against = "Estimate less truth" if known else "Estimate less dead reckoning, as no truth is known"
    plan = plan_of(record)
    ends = "" if plan.truth is None else f" {where_it_ends(plan, plan.truth)}."
    band = f" The band is ±{SIGMAS:g} standard deviations, as the estimate claims them." if _has_bounds(record) else ""
    figures = {
        "map": (map_figure(plan, THEMED, 8.4, bare=True), f"From above, metres.{ends}"),
        "errors": (error_figure(traces, THEMED), f"{against}, scan by scan.{band if known else ''}"),
        "distance": (distance_figure([("", traces)], THEMED), "Position error over the way travelled."),
        "iterations": (iterations_figure(alone, THEMED), "Iterations of the matcher."),
        "timing": (timing_figure(alone, THEMED), "Processing time of the mapped scans."),
    }
    return [
        (inline_svg(figure, f"{key}-{name}", f"{name}: {caption}"), caption)
        for name, (figure, caption) in figures.items()
        if figure is not None
    ]


def _has_bounds(record: RunRecord) -> bool:
    steps = record.traces.steps
    return "cov_xx" in (steps.dtype.names or ()) and bool(np.isfinite(steps["cov_xx"]).any())


def _timing(record: RunRecord) -> list[tuple[str, list[str]]]:
    mapped = record.traces.steps[record.traces.steps["mapped"] == 1]
    columns = {"line extraction": mapped["extraction_ms"], "SLAM in all": mapped["slam_ms"]}
    return [
        (name, [f"{value:.2f}" for value in np.percentile(column, PERCENTILES)])
        for name, column in columns.items()
        if len(column)
    ]
