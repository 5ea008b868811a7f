"""``hopslam lines``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import Lenient
from slam.console.terminal import Terminal


def lines(
    log: Annotated[Path, typer.Argument(help="A recorded log; its format is recognised.")],
    scan: Annotated[int | None, typer.Option(metavar="K", help="Use one scan only, counted from 0.")] = None,
    method: Annotated[str, typer.Option(metavar="NAME", help="chi_square, or paper.")] = "chi_square",
    csv: Annotated[Path | None, typer.Option(metavar="FILE", help="Write CSV to a file.")] = None,
    geojson: Annotated[Path | None, typer.Option(metavar="FILE", help="Write GeoJSON.")] = None,
    png: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the scan K of --scan.")] = None,
    sensor: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Sensor whose noise is assumed at first; then it is learnt from the scans."),
    ] = None,
    lenient: Lenient = False,
) -> None:
    """Find the line segments in the scans of a recorded log.

    They are written as CSV, by default to standard output, or as GeoJSON. Metres, radians, sensor frame. The columns
    are scan, start_x, start_y, end_x, end_y, beams, rho, theta, var_rho, var_theta, cov_rho_theta; the line is x
    cos(theta) + y sin(theta) = rho. The last three are empty if the method gives no covariance.

    [bold]Examples[/bold]

    hopslam lines mines1.dat.gz --scan 100 --png scan.png

    hopslam lines fr079.log.gz --csv segments.csv --geojson segments.geojson

    hopslam lines mines1.dat.gz --method paper | head
    """
    from slam.files.logs import read_log
    from slam.run.log_lines import Outputs, chosen_scans, line_config, write_lines

    console = Terminal(stderr=True)
    config = line_config(method, sensor)
    recorded = read_log(log)
    scans = chosen_scans(recorded, scan)
    console.print(recorded.report)
    outputs = Outputs(csv, geojson, png)
    with console.progress(transient=True) as bar:
        count = write_lines(recorded, scans, config, outputs, lambda all_: bar.track(all_, description="extracting"))
    console.print(f"{count} segments in {len(scans)} scan{'s' * (len(scans) != 1)}")
    if recorded.loss.warning:
        console.warn(recorded.loss.warning)
    recorded.loss.require_most(lenient)
