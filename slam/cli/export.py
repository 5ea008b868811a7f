"""``hopslam export``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.terminal import Terminal
from slam.run.export.formats import Format


def export(
    run: Annotated[Path, typer.Argument(help="The folder of a run.")],
    to: Annotated[Format, typer.Option(help="The format.")],
    out: Annotated[Path, typer.Option(metavar="PATH", help="The new file, or the new folder for ros and rosbag2.")],
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write a run in the format of another tool: see docs/formats.md.

    tum: trajectory; csv: every scan; ros: occupancy map; geojson, dxf, svg: line map; carmen, mcap, rosbag2: log; g2o:
    graph. All but the log use the final poses after loop closing.

    [bold]Examples[/bold]

    hopslam export runs/latest --to tum --out trajectory.tum

    hopslam export runs/latest --to ros --out office_map

    hopslam export runs/latest --to dxf --out walls.dxf

    hopslam export runs/latest --to g2o --out graph.g2o

    hopslam export runs/latest --to carmen --out run.log --force
    """
    from slam.run.export.formats import export as write
    from slam.run.results.run_record import RunRecord

    console, record = Terminal(), RunRecord.open(run)
    with console.waiting(f"writing {out}"):
        write(record, to, out, force)
    console.print(f"{out} written")
    console.warn(*record.warnings)
