"""``hopslam bench match``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, use_one_thread, write_tables
from slam.console.options import complete_scenario


def bench_match(
    scenario: Annotated[
        str, typer.Argument(help="Whose world is scanned: by name or file.", autocompletion=complete_scenario)
    ] = "random_office",
    places: Annotated[int, typer.Option(min=1, help="Where a scan is matched.")] = 40,
    seed: Annotated[int, typer.Option(help="Of the places and the noise.")] = 1,
    png: Annotated[Path | None, typer.Option(metavar="FILE", help="Also draw it.")] = None,
    out: TablesFile = None,
) -> None:
    """Compare matchers on the same scans: ours, the paper's, and small_gicp's (pip install 'hopslam\\[bench]').

    Time by the number of points, accuracy, and from how far away a start still converges.

    [bold]Examples[/bold]

    hopslam bench match

    hopslam bench match office_loop --places 100 --png match.png --out match.md
    """
    use_one_thread()
    from slam.bench.match_report import compare_matchers, draw_comparison, match_tables
    from slam.scenario.file import read_scenario

    found = compare_matchers(read_scenario(scenario), places, seed, console)
    tables = match_tables(found)
    print_tables(tables)
    if png is not None:
        draw_comparison(png, found)
    write_tables(out, tables, "Matchers on the same scans")
