"""``hopslam run``."""

from typing import Annotated, Literal

import typer

from slam.console.options import (
    AllowModules,
    DrivenByRos,
    Foxglove,
    FoxgloveAt,
    Out,
    Pace,
    RecordWire,
    Rerun,
    SavedMap,
    ScenarioName,
    Seed,
    Settings,
    Yes,
)
from slam.console.terminal import Terminal

Backend = Annotated[
    str,
    typer.Option(
        metavar="NAME", help="sim; hardware: the real robot; ros: a robot of ROS 2; or module:Class: your own."
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Use only the sensors of the real robot: it never moves.")]
Start = Annotated[
    Literal["given", "search"],
    typer.Option(help="Start in the map of --map; given: at the scenario's start pose; search: anywhere."),
]


def run(
    scenario: ScenarioName = "corridor",
    seed: Seed = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    ros: DrivenByRos = False,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
    pace: Pace = None,
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

    hopslam run office_loop --foxglove

    hopslam run office_loop --ros --set 'route.waypoints=[]' --set duration=3600

    hopslam run corridor --backend hardware --dry-run --set hardware.robot_port=/dev/ttyUSB1

    hopslam run corridor --backend hardware --record-wire corridor.wire
    """
    from slam.run.launch import run as launch
    from slam.run.run_and_report import run_and_report

    console = Terminal()
    run_and_report(
        lambda viewers: launch(
            scenario, seed=seed, settings=settings or (), out=out, saved_map=saved_map, start=start, backend=backend,
            allow_modules=allow_modules or (), ros=ros,
            foxglove=foxglove_at or foxglove, pace=pace, yes=yes, dry_run=dry_run,
            record_wire=record_wire, check=False, viewers=viewers, console=console,
        ),
        rerun,
        console,
    )  # fmt: skip
