"""``hopslam run``."""

from typing import Annotated, Literal

import typer

from slam.console.options import AllowModules, Out, Rerun, SavedMap, ScenarioName, Settings
from slam.console.terminal import Terminal
from slam.errors import InputError


def run(
    scenario: ScenarioName = "corridor",
    seed: Annotated[int | None, typer.Option(help="Seed of all that is random; default: the scenario's.")] = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
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

    The robot is simulated, or the real one at the ports in the scenario's section hardware: see docs/hardware.md.

    [bold]Examples[/bold]

    hopslam run corridor

    hopslam run paper_simulation --seed 3 --out /tmp/paper

    hopslam run paper_corridor --set slam.lines.psi=0 --set robot.odometry.track=0.33 --rerun corridor.rrd

    hopslam run office_loop --map runs/latest/map.json --start search

    hopslam run corridor --backend hardware --dry-run --set hardware.robot_port=/dev/ttyUSB1
    """
    from slam.cli.inputs import draw_with_warnings, with_seed
    from slam.run.experiment_setup import scenario_experiment
    from slam.run.run_and_report import run_and_report
    from slam.scenario.file import load_template

    if backend == "replay":
        raise InputError("--backend replay has no log to play; run: hopslam replay LOG")
    if backend != "hardware" and (yes or dry_run):
        raise InputError("--yes and --dry-run are for the real robot; add --backend hardware")
    console = Terminal()
    options = {"yes": yes, "dry_run": dry_run} if backend == "hardware" else {}
    loaded = draw_with_warnings(load_template(scenario, with_seed(settings, seed), allow_modules or []))
    experiment = scenario_experiment(loaded, backend, **options)
    if saved_map is not None:
        from slam.run.experiment_setup import continue_mapping

        experiment = continue_mapping(experiment, saved_map, start)
    run_and_report(experiment, out, rerun, console)
