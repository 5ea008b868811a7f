"""``hopslam bench slam``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, use_one_thread, write_tables
from slam.console.options import Settings


def bench_slam(
    logs: Annotated[
        list[str] | None, typer.Argument(metavar="[LOG]...", help="Names such as fr079; all without one.")
    ] = None,
    data: Annotated[Path, typer.Option(metavar="DIR", help="Where the recorded logs are.")] = Path("../shared/data"),
    settings: Settings = None,
    out: TablesFile = None,
) -> None:
    """Measure the whole method on recorded logs, with one set of settings for all, beside other systems.

    Every scan, at the pose that the method had for it then. A log that is not there is skipped.

    [bold]Examples[/bold]

    hopslam bench slam

    hopslam bench slam fr079 mines1 --data ~/logs --out /tmp/slam.md

    hopslam bench slam corridor_synthetic --set slam.matching.floor=0.02
    """
    use_one_thread()
    from slam.bench.slam_report import slam_tables
    from slam.scenario.file import load_scenario

    made = slam_tables(logs or [], data, load_scenario("replay", settings or []).slam, console)
    print_tables(made)
    write_tables(out, made, "SLAM on recorded logs")
