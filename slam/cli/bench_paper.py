"""``hopslam bench paper``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import console, print_tables, use_one_thread


def bench_paper(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report and the pictures.")] = Path(
        "bench/paper"
    ),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer points and trials: seconds, not minutes.")] = False,
) -> None:
    """Measure Table 2, Figs. 3, 7, 8 and 10 and the time of Fig. 21 of the paper again, beside its own numbers.

    The whole of Table 2 takes some minutes, nearly all of it for the full U that the paper's SVD has.

    [bold]Examples[/bold]

    hopslam bench paper --quick

    hopslam bench paper --out /tmp/paper
    """
    use_one_thread()
    from slam.bench.paper.report import reproduce

    report = reproduce(out, quick, console)
    print_tables(report.tables)
    console.print(f"report and pictures in {report.path.parent}")
