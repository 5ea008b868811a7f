"""``hopslam bench localize``."""

from typing import Annotated

import typer

from slam.cli.bench import console, print_tables, use_one_thread
from slam.console.options import AllowModules, Settings, complete_scenario


def bench_localize(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="By name or file; two offices without one.", autocompletion=complete_scenario
        ),
    ] = None,
    trials: Annotated[int, typer.Option(min=1, help="Robots that are set down, and then moved, in each.")] = 100,
    seconds: Annotated[float, typer.Option(min=1.0, help="Simulated time of each stay.")] = 10.0,
    seed: Annotated[int, typer.Option(help="Of the places, and of the trials' noise.")] = 1,
    settings: Settings = None,
    allow_modules: AllowModules = None,
) -> None:
    """Measure localisation in a saved map: from a random place, and after the robot was moved without being told.

    One run maps the world of the scenario; the robots wander on their scans alone.

    [bold]Examples[/bold]

    hopslam bench localize

    hopslam bench localize random_office --trials 20 --seed 5 --set seed=3
    """
    use_one_thread()
    from slam.bench.localize_report import localization_table
    from slam.scenario.file import load_scenario

    for name in scenarios or ["office_loop", "random_office"]:
        scenario = load_scenario(name, ["lidar.caster=exact", *(settings or [])], allow_modules or [])
        print_tables([localization_table(scenario, trials, seconds, seed, console)])
