"""``hopslam bench start``."""

from typing import Annotated

import typer

from slam.cli.bench import console, print_tables
from slam.console.options import AllowModules, ScenarioName


def bench_start(
    scenario: ScenarioName = "corridor",
    repeats: Annotated[int, typer.Option(min=1, help="Starts of each kind.")] = 5,
    allow_modules: AllowModules = None,
) -> None:
    """Measure how long a user waits: for the help, and for the first scan of a run, with warm caches.

    [bold]Examples[/bold]

    hopslam bench start

    hopslam bench start office_loop --repeats 20
    """
    from slam.bench.start_up import start_up_table

    print_tables([start_up_table(scenario, repeats, console, allow_modules or [])])
