"""A run as the commands make it: with viewers, a summary and an exit code."""

from __future__ import annotations

from pathlib import Path

import typer

from slam.console.terminal import Terminal
from slam.run.experiment import Experiment
from slam.run.results.summary import summary_tables
from slam.run.viewer.viewers import Viewers


def run_and_report(experiment: Experiment, out: Path | None, rerun: list[str] | None, console: Terminal) -> None:
    """Run the experiment, print its summary, and keep the web viewer open until Ctrl-C where there is one.

    Raises the error of a run that failed. Leaves with exit code 130 after Ctrl-C, 128 + N after the signal N.
    """
    with Viewers(rerun or (), console) as viewers:
        outcome = experiment.run(out, viewers, console)
        console.print(*summary_tables(outcome.metrics))
        console.print(f"{outcome.ending}; results in {outcome.folder}")
        if outcome.error is not None:
            raise outcome.error
        if outcome.ending == "interrupted":
            raise typer.Exit(128 + outcome.signal)
        viewers.serve_until_interrupted()
