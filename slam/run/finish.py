"""How a command that made a run ends."""

from __future__ import annotations

import typer
from rich.console import Console

from slam.run.experiment import Outcome
from slam.run.results.summary import summary_table


def finish(outcome: Outcome) -> None:
    """Show what came out; raises the error of a robot that failed, and leaves with 130 after Ctrl-C."""
    console = Console()
    console.print(summary_table(outcome.metrics))
    console.print(f"{outcome.ending}; results in {outcome.folder}", highlight=False)
    if outcome.error is not None:
        raise outcome.error
    if outcome.ending == "interrupted":
        raise typer.Exit(130)
