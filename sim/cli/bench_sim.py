"""``hopslam bench sim``."""

from typing import Annotated

import typer


def bench_sim(
    long: Annotated[
        bool, typer.Option("--long", help="Also measure memory over 10,000 resets, 1.2 million steps; takes minutes.")
    ] = False,
) -> None:
    """Measure the simulator: its speed and that of PyBullet's calls alone, resets, two processes at once, contacts.

    The contacts are those of a robot that drives against walls, people and sills.

    [bold]Examples[/bold]

    hopslam bench sim

    hopslam bench sim --long
    """
    from sim.bench.report import sim_tables
    from slam.console.terminal import Terminal

    console = Terminal()
    for table in sim_tables(long, console):
        console.print(table.for_terminal())
