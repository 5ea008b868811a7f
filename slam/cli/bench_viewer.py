"""``hopslam bench viewer``."""

from typing import Annotated

import typer

from slam.cli.bench import console, print_tables
from slam.console.options import AllowModules, ScenarioName


def bench_viewer(
    scenario: ScenarioName = "corridor",
    scans: Annotated[int, typer.Option(min=10, help="For each row at 10 Hz.")] = 150,
    allow_modules: AllowModules = None,
) -> None:
    """Measure what --rerun costs: milliseconds and kilobytes a scan, in a file, and live when nobody looks.

    Takes about two minutes.

    [bold]Examples[/bold]

    hopslam bench viewer

    hopslam bench viewer office_loop --scans 50
    """
    from slam.bench.viewer_cost import viewer_table
    from slam.scenario.file import load_scenario

    print_tables([viewer_table(load_scenario(scenario, [], allow_modules or []), scans, console)])
