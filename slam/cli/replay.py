"""``hopslam replay``."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from slam.console.options import (
    AllowModules,
    Foxglove,
    FoxgloveAt,
    Lenient,
    OdomTopic,
    Out,
    Pace,
    Rerun,
    Ros,
    SavedMap,
    ScanTopic,
    Settings,
    complete_scenario,
)
from slam.console.terminal import Terminal

RecordedLog = Annotated[
    Path,
    typer.Argument(
        help="A CARMEN log or a URG-04LX text log, plain or gzipped; a ROS 1 bag, the folder of a ROS 2 bag, "
        "or an MCAP file; or the folder of a run."
    ),
]
SettingsSource = Annotated[
    str | None,
    typer.Option(
        help="Scenario with the settings of the method; default: the run's own, or replay.",
        autocompletion=complete_scenario,
    ),
]
Start = Annotated[
    Literal["search", "saved"],
    typer.Option(help="Start in the map of --map; search: anywhere; saved: at the last pose of the other run."),
]


def replay(
    log: RecordedLog,
    scenario: SettingsSource = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    ros: Ros = False,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
    pace: Pace = None,
    saved_map: SavedMap = None,
    start: Start = "search",
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    lenient: Lenient = False,
) -> None:
    """Map a recorded log of a robot, or repeat a run.

    [bold]Examples[/bold]

    hopslam replay fr079.log.gz

    hopslam replay mines1.dat.gz --out /tmp/mines --set slam.update_distance=0.1

    hopslam replay robot.bag --scan-topic /base_scan --odom-topic /odom

    hopslam replay runs/latest --set slam.deskew=false

    hopslam replay robot.mcap --ros --foxglove --pace 4

    hopslam replay second_half.log --map runs/latest/map.json --start saved
    """
    from slam.run.launch import replay as launch
    from slam.run.run_and_report import run_and_report

    console = Terminal()
    run_and_report(
        lambda viewers: launch(
            log, scenario=scenario, settings=settings or (), out=out, saved_map=saved_map, start=start,
            scan_topic=scan_topic, odom_topic=odom_topic, allow_modules=allow_modules or (), ros=ros,
            foxglove=foxglove_at or foxglove, pace=pace, check=False,
            viewers=viewers, console=console,
        ),
        rerun,
        console,
        lenient,
    )  # fmt: skip
