"""``hopslam bench sim``."""

from typing import Annotated

import typer


def bench_sim(
    long: Annotated[
        bool, typer.Option("--long", help="Also 10,000 resets and a million steps: some minutes, for the memory.")
    ] = False,
) -> None:
    """Measure the simulator: speed beside PyBullet's calls alone, resets, two processes against one, and contacts.

    Contacts: what walls, people and sills do to a robot that is pushed against them.

    [bold]Examples[/bold]

    hopslam bench sim

    hopslam bench sim --long
    """
    from sim.bench.report import sim_tables
    from slam.console.terminal import Terminal

    console = Terminal()
    for table in sim_tables(long, console):
        console.print(table.for_terminal())
