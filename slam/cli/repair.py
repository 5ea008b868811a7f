"""``hopslam repair``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.terminal import Terminal


def repair(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    force: Annotated[bool, typer.Option("--force", help="Also replace intact files.")] = False,
) -> None:
    """Make the files that a killed run, or one with a full disk, lacks: map, poses, lines, graph, metrics, pictures.

    The source is log.mcap, as far as it can be read, with the settings in config.yaml. Intact files are kept.

    [bold]Examples[/bold]

    hopslam repair runs/latest

    hopslam repair runs/latest --force
    """
    from slam.run.repair import repair as make_again

    console = Terminal()
    done = make_again(run, console, force)
    for what, names in (("made", done.made), ("kept", done.kept), ("not made", done.missing)):
        if names:
            console.print(f"{what}: {', '.join(names)}")
