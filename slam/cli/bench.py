"""``hopslam bench``: the table of its commands, and their common functions."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from slam.cli.lazy_group import lazy_group
from slam.console.terminal import Terminal

if TYPE_CHECKING:
    from slam.console.result_table import ResultTable

TablesFile = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="Also write the tables to a Markdown file.")
]
BENCHES: Final = {
    "paper": "slam.cli.bench_methods:bench_paper",
    "lines": "slam.cli.bench_methods:bench_lines",
    "slam": "slam.cli.bench_methods:bench_slam",
    "loops": "slam.cli.bench_loops:bench_loops",
    "localize": "slam.cli.bench_methods:bench_localize",
    "match": "slam.cli.bench_methods:bench_match",
    "sweep": "slam.cli.bench_costs:bench_sweep",
    "slam-sim": "slam.cli.bench_methods:bench_slam_sim",
    "walls": "slam.cli.bench_methods:bench_walls",
    "viewer": "slam.cli.bench_costs:bench_viewer",
    "start": "slam.cli.bench_costs:bench_start",
    "ros": "slam.cli.bench_costs:bench_ros",
    "sim": "sim.cli.bench_sim:bench_sim",
    "env": "sim.cli.bench_env:bench_env",
    "hardware": "hardware.cli.bench_hardware:bench_hardware",
    "policy": "hardware.cli.bench_policy:bench_policy",
}
"""Every benchmark by its name, with the place of its function."""
app = typer.Typer(cls=lazy_group(BENCHES), no_args_is_help=True, add_completion=False)
console = Terminal()


@app.callback()
def _bench() -> None:
    """Measure the parts: figures of the paper, methods, SLAM, simulator, environments, drivers, sweeps, start-up."""


def use_one_thread() -> None:
    """Limit numpy's BLAS to one thread, as threads would wait for each other; call it before numpy is imported."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def print_tables(tables: Iterable[ResultTable], path: Path | None = None, title: str = "") -> None:
    """Print tables as they come, then write them to a Markdown file, if its path is given.

    InputError if the file cannot be written, StorageError if the disk fails.
    """
    printed = []
    for table in tables:
        console.print(table.for_terminal())
        printed.append(table)
    if path is None:
        return
    from slam.files.atomic_files import require_writable, write_atomic

    text = f"# {title}\n\n" + "".join(table.markdown() for table in printed)
    with require_writable(path, "choose another --out FILE"):
        write_atomic(path, text.rstrip() + "\n")
