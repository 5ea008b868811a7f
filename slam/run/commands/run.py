"""``hopslam run``."""

from __future__ import annotations

from typing import Annotated, Literal

import typer
from rich.console import Console

from slam.errors import InputError
from slam.run.commands.options import Out, Rerun, SavedMap, Settings


def run(
    scenario: Annotated[str, typer.Argument(help="Name of a shipped scenario, or a path to a YAML file.")] = "corridor",
    seed: Annotated[int | None, typer.Option(help="Seed of all that is random; default: the scenario's.")] = None,
    out: Out = None,
    settings: Settings = None,
    rerun: Rerun = None,
    backend: Annotated[
        str, typer.Option(metavar="NAME", help="sim; hardware, the real robot; or module:Class, one of your own.")
    ] = "sim",
    yes: Annotated[bool, typer.Option("--yes", help="The real robot moves without asking first.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="The real robot's sensors only: it never moves.")] = False,
    saved_map: SavedMap = None,
    start: Annotated[
        Literal["given", "search"], typer.Option(help="Where in that map: the scenario's start, or to be found.")
    ] = "given",
) -> None:
    """Drive a robot through a scenario, and map it.

    The robot is simulated, or the real one at the ports in the scenario's section hardware: see docs/bench.md.

    [bold]Examples[/bold]

    hopslam run corridor

    hopslam run paper_simulation --seed 3 --out /tmp/paper

    hopslam run paper_corridor --set slam.lines.psi=0 --set robot.odometry.track=0.33 --rerun corridor.rrd

    hopslam run office_loop --map runs/latest/map.json --start search

    hopslam run corridor --backend hardware --dry-run --set hardware.robot_port=/dev/ttyUSB1
    """
    from slam.run.commands.scenario_file import load_with_warnings
    from slam.run.conduct import conduct
    from slam.run.experiment import scenario_experiment

    if backend == "replay":
        raise InputError("--backend replay has no log to play; run: hopslam replay LOG")
    if backend != "hardware" and (yes or dry_run):
        raise InputError("--yes and --dry-run are for the real robot; add --backend hardware")
    console = Console()
    options = {"yes": yes, "dry_run": dry_run} if backend == "hardware" else {}
    experiment = scenario_experiment(load_with_warnings(scenario, settings, seed), backend, **options)
    if saved_map is not None:
        from slam.run.localization import continued

        experiment = continued(experiment, saved_map, start)
    conduct(experiment, out, rerun, console)
