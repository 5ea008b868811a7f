"""``hopslam optimize``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import AllowModules, Settings
from slam.console.terminal import Terminal


def optimize(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    settings: Settings = None,
    allow_modules: AllowModules = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A new folder for the results; default: the run's own.")
    ] = None,
) -> None:
    """Close the loops of a run again, with other settings, or after the run was killed.

    The scans of its log are matched again; then closed.tum, graph.json, map.json, metrics.json and the pictures are
    written. The estimates made during the run, such as trajectory.tum, do not change. The same settings give the same
    files.

    [bold]Examples[/bold]

    hopslam optimize runs/latest

    hopslam optimize runs/latest --set slam.matching.kernel=0.05 --out /tmp/wider

    hopslam compare runs/latest /tmp/wider
    """
    from slam.files.atomic_files import require_writable
    from slam.run.optimize import Optimization
    from slam.run.results.run_record import RunRecord
    from slam.run.run_and_report import summary_tables
    from slam.scenario.file import load_scenario

    console, record = Terminal(), RunRecord.open(run)
    scenario = load_scenario(record.folder / "config.yaml", settings or [], allow_modules or [])
    with require_writable(out or run, "make room, or give --out DIR elsewhere"):
        folder, metrics = Optimization(record, scenario, settings or []).run(out, console)
    console.print(*summary_tables(metrics))
    console.print(f"loops closed; results in {folder}")
    console.warn(*record.warnings)
