"""``hopslam bench lines``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, write_tables


def bench_lines(
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A recorded log, instead of simulated scans.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=60, help="Seeds of each family of floor plan.")] = 60,
    sensor: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --log: whose noise ours expects; estimated without it.")
    ] = None,
    out: TablesFile = None,
) -> None:
    """Compare line extractors: the paper's, this project's, split-and-merge, RANSAC and Hough.

    On simulated scans of four families at three levels of noise, with seeds that nothing was tuned on; or on a recorded
    log, where only the share of the beams near a segment can be told.

    [bold]Examples[/bold]

    hopslam bench lines

    hopslam bench lines --seeds 5 --out /tmp/lines.md

    hopslam bench lines --log mines1.dat.gz --sensor urg04lx
    """
    from slam.bench.lines_report import log_tables, scene_tables

    tables = scene_tables(seeds, console) if log is None else log_tables(log, console, sensor)
    print_tables(tables)
    write_tables(out, tables, "Line extractors side by side")
