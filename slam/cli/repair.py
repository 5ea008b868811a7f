"""``hopslam repair``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.terminal import Terminal


def repair(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    force: Annotated[bool, typer.Option("--force", help="Also replace files that are whole.")] = False,
) -> None:
    """Make what a killed run or a full disk has left out: map, trajectories, lines, graph, metrics and pictures.

    All is made from log.mcap, as far as it reaches, with the settings in config.yaml. Files that are whole stay.

    [bold]Example[/bold]

    hopslam repair runs/latest

    hopslam repair runs/latest --force
    """
    from slam.run.repair import repair as make_again

    console = Terminal()
    done = make_again(run, console, force)
    for what, names in (("made", done.made), ("kept", done.kept), ("not made", done.missing)):
        if names:
            console.print(f"{what}: {', '.join(names)}")
