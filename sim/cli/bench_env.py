"""``hopslam bench env``."""

from typing import Annotated

import typer


def bench_env(
    peer: Annotated[
        bool, typer.Option("--peer", help="Also measure ir-sim, in the same world with the same number of beams.")
    ] = False,
) -> None:
    """Measure the learning environments: steps per second of every kind, threads, and the memory of a robot.

    The kinds are physics, the kinematic model, and batches of it with each view, on one core.

    [bold]Examples[/bold]

    hopslam bench env

    hopslam bench env --peer
    """
    from sim.bench.env_speed import env_tables
    from slam.console.terminal import Terminal

    console = Terminal()
    for table in env_tables(console, peer=peer):
        console.print(table.for_terminal())
