"""``hopslam view``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console


def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")] = Path("runs/latest"),
    rerun: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WHERE",
            help="In FILE.rrd, spawn, connect[=HOST:PORT] or serve[=PORT]; may be given again. Default: spawn.",
        ),
    ] = None,
) -> None:
    """Open a finished run in the rerun viewer, as it happened.

    Its recording run.rrd is shown; a run that was made without --rerun gets one from what its folder holds.

    [bold]Examples[/bold]

    hopslam view

    hopslam view runs/latest --rerun serve

    hopslam view /tmp/paper --rerun paper.rrd
    """
    from rich.progress import track

    from slam.run.viewer.recording import recording_of
    from slam.run.viewer.viewers import Viewers

    console = Console()
    with Viewers(rerun or ["spawn"], console) as viewers:
        recording = recording_of(
            run, lambda scans, total: track(scans, "making run.rrd", total, console=console, transient=True)
        )
        viewers.open_file(recording)
        viewers.linger()
