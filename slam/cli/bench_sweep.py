"""``hopslam bench sweep``."""

from typing import Annotated

import typer

from slam.cli.bench import console, print_tables


def bench_sweep(
    runs: Annotated[
        int, typer.Option(min=2, help="Of each executor, with one job and with two, in each of five turns.")
    ] = 15,
    ray: Annotated[bool, typer.Option("--ray/--no-ray", help="Ray too: pip install 'hopslam\\[cluster]'.")] = True,
) -> None:
    """Measure sweeps: runs a second with one job and with two, the driver's share of a core, overhead, memory.

    Some minutes. Quiet machines give better numbers: what two processes can do at all is measured in the same run.

    [bold]Examples[/bold]

    hopslam bench sweep

    hopslam bench sweep --runs 6 --no-ray
    """
    from slam.bench.sweep_report import sweep_tables

    print_tables(sweep_tables(runs, ray, console))
