"""``hopslam localize``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import (
    AllowModules,
    DrivenByRos,
    Foxglove,
    FoxgloveAt,
    Lenient,
    OdomTopic,
    Out,
    Pace,
    Rerun,
    ScanTopic,
    Settings,
    complete_scenario,
)
from slam.console.terminal import Terminal

Source = Annotated[
    str,
    typer.Argument(
        metavar="LOG|SCENARIO",
        help="A log, a bag or a run folder, as for hopslam replay; or a scenario.",
        autocompletion=complete_scenario,
    ),
]
SettingsSource = Annotated[
    str | None,
    typer.Option(
        help="Scenario with the settings of the method for a log; default: the run's own, or replay.",
        autocompletion=complete_scenario,
    ),
]


def localize(
    source: Source,
    saved_map: Annotated[Path, typer.Option("--map", metavar="FILE", help="The map.json of another run.")],
    seed: Annotated[
        int | None, typer.Option(help="Seed of all random numbers of a scenario; default: its own.")
    ] = None,
    scenario: SettingsSource = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    ros: DrivenByRos = False,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
    pace: Pace = None,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    lenient: Lenient = False,
) -> None:
    """Find the robot in a saved map, without a start pose, and track it. The map does not change.

    A simulated robot wanders until it is sure of its pose, and then drives the scenario's route.

    [bold]Examples[/bold]

    hopslam run office_loop --out /tmp/office

    hopslam localize office_loop --map /tmp/office/map.json --seed 7 --set robot.start.x=3 --set robot.start.theta=2

    hopslam localize fr079.log.gz --map runs/latest/map.json --set slam.localization.hypotheses=100

    hopslam localize runs/latest --map /tmp/office/map.json

    hopslam localize office_loop --map /tmp/office/map.json --foxglove
    """
    from slam.run.launch import localize as launch
    from slam.run.run_and_report import run_and_report

    console = Terminal()
    run_and_report(
        lambda viewers: launch(
            source, saved_map, scenario=scenario, seed=seed, settings=settings or (), out=out, scan_topic=scan_topic,
            odom_topic=odom_topic, allow_modules=allow_modules or (), ros=ros,
            foxglove=foxglove_at or foxglove, pace=pace, check=False, viewers=viewers, console=console,
        ),
        rerun,
        console,
        lenient,
    )  # fmt: skip
