"""``hopslam run``."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from slam.console.options import AllowModules, Out, RecordWire, Rerun, SavedMap, ScenarioName, Seed, Settings, Yes
from slam.console.terminal import Terminal
from slam.errors import InputError

Backend = Annotated[
    str, typer.Option(metavar="NAME", help="sim; hardware, the real robot; or module:Class, one of your own.")
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="The real robot's sensors only: it never moves.")]
Start = Annotated[
    Literal["given", "search"], typer.Option(help="Where in that map: the scenario's start, or to be found.")
]


def run(
    scenario: ScenarioName = "corridor",
    seed: Seed = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    backend: Backend = "sim",
    yes: Yes = False,
    dry_run: DryRun = False,
    record_wire: RecordWire = None,
    saved_map: SavedMap = None,
    start: Start = "given",
) -> None:
    """Drive a robot through a scenario, and map it.

    The robot is simulated, or the real one at the ports in the scenario's section hardware: see docs/hardware.md.

    [bold]Examples[/bold]

    hopslam run corridor

    hopslam run paper_simulation --seed 3 --out /tmp/paper

    hopslam run paper_corridor --set slam.lines.psi=0 --set robot.odometry.track=0.33 --rerun corridor.rrd

    hopslam run office_loop --map runs/latest/map.json --start search

    hopslam run corridor --backend hardware --dry-run --set hardware.robot_port=/dev/ttyUSB1

    hopslam run corridor --backend hardware --record-wire corridor.wire
    """
    from slam.cli.inputs import draw_with_warnings, with_seed
    from slam.run.experiment_setup import continue_mapping, scenario_experiment
    from slam.run.run_and_report import run_and_report
    from slam.scenario.file import load_template

    options = _robot_options(backend, yes, dry_run, record_wire)
    template = load_template(scenario, with_seed(settings, seed), allow_modules or [])
    experiment = scenario_experiment(draw_with_warnings(template), backend, **options)
    if saved_map is not None:
        experiment = continue_mapping(experiment, saved_map, start)
    run_and_report(experiment, out, rerun, Terminal())


def _robot_options(backend: str, yes: bool, dry_run: bool, record_wire: Path | None) -> dict[str, Any]:
    """Options of the back end; InputError for those that it does not have."""
    if backend == "hardware":
        return {"yes": yes, "dry_run": dry_run, "record_wire": record_wire}
    if backend == "replay":
        raise InputError("--backend replay has no log to play; run: hopslam replay LOG")
    if yes or dry_run or record_wire:
        raise InputError("--yes, --dry-run and --record-wire are for the real robot; add --backend hardware")
    return {}
