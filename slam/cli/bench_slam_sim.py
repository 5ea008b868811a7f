"""``hopslam bench slam-sim``."""

from typing import Annotated

import typer

from slam.cli.bench import TablesFile, console, print_tables, use_one_thread, write_tables
from slam.console.options import AllowModules, Settings, complete_scenario


def bench_slam_sim(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENARIO]...", help="Names such as corridor; six without one.", autocompletion=complete_scenario
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=0, max=100, help="Runs of each scenario; 0 with --hour alone.")] = 10,
    first_seed: Annotated[int, typer.Option(min=0, help="Of these runs; the others follow.")] = 0,
    hour: Annotated[bool, typer.Option("--hour", help="Also one simulated hour around office_loop: minutes.")] = False,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    out: TablesFile = None,
) -> None:
    """Measure the whole method in the simulator, against the truth: errors, covariances, costs.

    [bold]Examples[/bold]

    hopslam bench slam-sim

    hopslam bench slam-sim corridor office_loop --first-seed 10 --seeds 3

    hopslam bench slam-sim --seeds 0 --hour

    hopslam bench slam-sim crowded_corridor --set slam.map.free_margin=0.1 --out /tmp/crowd.md
    """
    use_one_thread()
    from slam.bench.sim_report import sim_tables

    runs = range(first_seed, first_seed + seeds)
    made = sim_tables(scenarios or [], runs, hour, tuple(settings or ()), console, tuple(allow_modules or ()))
    print_tables(made)
    write_tables(out, made, "SLAM in the simulator")
