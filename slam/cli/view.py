"""``hopslam view``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.terminal import Terminal


def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")] = Path("runs/latest"),
    rerun: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WHERE",
            help="FILE.rrd, spawn, connect[=HOST:PORT] or serve[=PORT]; may be given again. Default: spawn.",
        ),
    ] = None,
) -> None:
    """Open a finished run in the rerun viewer, scan by scan.

    It shows the recording run.rrd; for a run made without --rerun, it is made from the other files of the folder.

    [bold]Examples[/bold]

    hopslam view

    hopslam view runs/latest --rerun serve

    hopslam view /tmp/paper --rerun paper.rrd
    """
    from slam.run.viewer.finished_run import recording_of
    from slam.run.viewer.viewers import Viewers

    console = Terminal()
    with Viewers(rerun or ["spawn"], console) as viewers:
        with console.progress(transient=True) as bar:
            recording = recording_of(run, lambda scans, total: bar.track(scans, total, description="making run.rrd"))
        viewers.open_file(recording)
        viewers.serve_until_interrupted()
