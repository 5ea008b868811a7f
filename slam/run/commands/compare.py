"""``hopslam compare``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from slam.errors import InputError

if TYPE_CHECKING:
    from slam.run.results.run_record import RunRecord


def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN RUN ...", help="The folders of runs.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, and no table.")] = False,
) -> None:
    """Show the metrics of runs side by side, each with its difference from the first.

    [bold]Examples[/bold]

    hopslam compare runs/before runs/after

    hopslam compare runs/corridor-*

    hopslam compare runs/corridor-* --json
    """
    from slam.run.results.run_record import RunRecord

    if len(runs) < 2:
        raise InputError(f"compare: {runs[0]} alone; give two runs or more")
    records = [RunRecord.open(run) for run in runs]
    if as_json:
        typer.echo(json.dumps(dict(zip(map(str, runs), metrics_of(records), strict=True)), indent=2))
    else:
        Console().print(comparison(records))


def metrics_of(records: list[RunRecord]) -> list[dict[str, Any]]:
    """Of each run; of one that was cut off, those that can be measured afterwards."""
    from slam.run.results.metrics import measure

    return [measure(record.folder) if record.metrics is None else record.metrics for record in records]


def comparison(records: list[RunRecord]) -> Table:
    """A row for each metric that a run has."""
    metrics = metrics_of(records)
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    for number, record in enumerate(records):
        table.add_column(record.name, justify="right", overflow="fold")
        if number:
            table.add_column("", justify="right")
    for key in dict.fromkeys(key for of_run in metrics for key in of_run):
        table.add_row(key, *_cells([of_run.get(key) for of_run in metrics]))
    return table


def _cells(values: list[Any]) -> list[str]:
    """The first value; then each of the others, and how it differs."""
    cells = [_text(values[0])]
    for value in values[1:]:
        cells.extend((_text(value), _difference(value, values[0])))
    return cells


def _difference(value: Any, first: Any) -> str:
    if not _is_number(value) or not _is_number(first) or value == first:
        return ""
    share = f" ({100 * (value - first) / abs(first):+.0f} %)" if first else ""
    return f"{value - first:+.4g}{share}"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Any) -> str:
    return "-" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
