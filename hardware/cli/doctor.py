"""``hopslam doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slam.errors import InputError

if TYPE_CHECKING:
    from slam.scan import LaserScan


def doctor(
    ports: Annotated[list[str] | None, typer.Argument(help="Ports to examine; all by default.")] = None,
    lidar_baud: Annotated[int, typer.Option(metavar="RATE", help="First bit rate to try with a lidar.")] = 500000,
    png: Annotated[Path, typer.Option(metavar="FILE", help="Picture of a lidar's scan.")] = Path("scan.png"),
) -> None:
    """Find out which devices answer on the serial ports, or what keeps them from answering. Nothing moves.

    [bold]Examples[/bold]

    hopslam doctor

    hopslam doctor /dev/ttyACM0 --png scan.png

    hopslam doctor socket://192.168.1.7:4001
    """
    from hardware.doctor import examine
    from hardware.doctor import ports as connected_ports
    from slam.console.terminal import Terminal

    console = Terminal()
    named = ports or connected_ports()
    if not named:
        console.print("no serial ports; plug a device in, and look at the last lines of: sudo dmesg")
    for port in named:
        finding = examine(port, lidar_baud)
        console.print(f"{port}: {finding.words}")
        if finding.scan is not None:
            _draw(png, finding.scan, port)
            console.print(f"its scan is drawn in {png}")


def _draw(png: Path, scan: LaserScan, port: str) -> None:
    from slam.config import ChiSquareConfig
    from slam.lines.extraction import extract_segments
    from slam.run.pictures.scan_picture import draw_scan

    try:
        draw_scan(png, scan.points(), extract_segments(scan, ChiSquareConfig(sensor="urg04lx")), port)
    except OSError as error:
        raise InputError(f"{png}: cannot be written: {error.strerror}") from error
