"""``hopslam compare``."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable
from slam.errors import InputError

if TYPE_CHECKING:
    from slam.run.results.run_record import RunRecord

_HEAD: Final = 16
"""Characters per line of a column's head."""


def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN RUN ...", help="The folders of runs.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
) -> None:
    """Show the metrics of runs side by side, each with its difference from the first run.

    A difference is in percent; if one value is at least twice the other, it is a factor, such as x 3.1 or / 3.1.

    [bold]Examples[/bold]

    hopslam compare runs/before runs/after

    hopslam compare runs/corridor-*

    hopslam compare runs/corridor-* --json
    """
    from slam.run.results.run_record import RunRecord

    if len(runs) < 2:
        raise InputError(f"compare: {runs[0]} alone; give two runs or more")
    records = [RunRecord.open(run) for run in runs]
    Terminal().warn(*(text for record in records for text in record.warnings))
    if as_json:
        typer.echo(json.dumps(dict(zip(map(str, runs), metrics_of(records), strict=True)), indent=2))
    else:
        Terminal().print(comparison(records))


def metrics_of(records: list[RunRecord]) -> list[dict[str, Any]]:
    """Return the metrics of each run; for an interrupted run, those that can be measured afterwards."""
    from slam.run.results.metrics import measure

    return [measure(record.folder) if record.metrics is None else record.metrics for record in records]


def comparison(records: list[RunRecord]) -> TerminalTable:
    """Make a row for each metric that a run has and a column for each run, headed by what distinguishes it."""
    from slam.run.results.run_names import run_names

    folders = [record.name for record in records]
    names = folders if len(set(folders)) == len(folders) else run_names(records)
    metrics = metrics_of(records)
    keys = dict.fromkeys(key for of_run in metrics for key in of_run)
    rows = [(key, *_cells([_shown(key, of_run.get(key)) for of_run in metrics])) for key in keys]
    return TerminalTable(("", *map(_head, names)), rows)


def _shown(key: str, value: Any) -> Any:
    """Return the value; the seed as text, and the date as text without seconds and time zone."""
    if key == "began" and value:
        return str(value)[:16].replace("T", " ")
    return str(value) if key == "seed" and value is not None else value


def _head(name: str) -> str:
    """Break a name between its words into lines as short as a number."""
    lines = [""]
    for word in re.findall(r"[^-_, ]+[-_, ]*|[-_, ]+", name):
        if lines[-1] and len(lines[-1]) + len(word) > _HEAD:
            lines.append("")
        lines[-1] += word
    return "\n".join(line.strip() for line in lines)


def _cells(values: list[Any]) -> list[str]:
    """Return the first value; then the others, each with its difference from the first."""
    return [_text(values[0]), *(f"{_text(value)}{_difference(value, values[0])}" for value in values[1:])]


def _difference(value: Any, first: Any) -> str:
    """Format a difference in percent, or as a factor if the value is at least twice or at most half as large.

    It is absolute if the first value is 0 or of another sign.
    """
    if not _is_number(value) or not _is_number(first) or value == first:
        return ""
    if not first or value / first <= 0.0:
        return f" ({value - first:+.3g})"
    ratio = value / first
    if 0.5 < ratio < 2.0:
        return f" ({100 * (ratio - 1):+.2g} %)"
    return f" (x {ratio:.3g})" if ratio > 1.0 else f" (/ {1 / ratio:.3g})"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Any) -> str:
    return "-" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
