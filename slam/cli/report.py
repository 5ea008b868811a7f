"""``hopslam report`` and ``hopslam animate``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.terminal import Terminal


def report(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs; several are compared.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The page; default report.html in the first run's folder.")
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Also write every figure, including the paper's, as PNG and PDF into DIR."),
    ] = None,
) -> None:
    """Write a report on a run, or on several side by side.

    The report is one HTML file that needs no network, with faults, map, metrics, errors, iterations, timing and
    settings.

    [bold]Examples[/bold]

    hopslam report runs/latest

    hopslam report runs/corridor-* --out corridors.html

    hopslam report runs/latest --figures figures
    """
    from slam.files.atomic_files import require_writable
    from slam.run.report.page import write_report
    from slam.run.results.run_record import RunRecord

    records = [RunRecord.open(folder) for folder in runs]
    path = out or runs[0] / "report.html"
    with require_writable(None, "choose another place"):
        write_report(records, path)
        typer.echo(f"report in {path}")
        if figures is not None:
            from slam.run.report.figure_files import write_figures

            typer.echo(f"{write_figures(records, figures)} figures, each as PNG and PDF, in {figures}")
    Terminal().warn(*(text for record in records for text in record.warnings))


def animate(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help=".webp, or .gif; default map.webp in the run's folder.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=1.0, max=60.0, help="Length of the animation in seconds.")] = 8.0,
    width: Annotated[int, typer.Option(min=200, max=1920, help="Width in pixels.")] = 960,
) -> None:
    """Draw the map of a run as it grows, as a short animation.

    [bold]Examples[/bold]

    hopslam animate runs/latest

    hopslam animate runs/latest --out corridor.gif --seconds 12 --width 640
    """
    from slam.run.report.animation import write_animation
    from slam.run.results.run_record import RunRecord

    path, record = out or run / "map.webp", RunRecord.open(run)
    write_animation(record, path, seconds, width)
    typer.echo(f"animation in {path}")
    Terminal().warn(*record.warnings)
