"""``hopslam ros``: this project's SLAM among the nodes of ROS 2."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from slam.console.options import (
    AllowModules,
    Foxglove,
    FoxgloveAt,
    Out,
    Rerun,
    SavedMap,
    Settings,
    complete_scenario,
)
from slam.console.terminal import Terminal

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode="rich")

SettingsSource = Annotated[
    str,
    typer.Option(
        help="Scenario with the settings of the method and the names of the topics.",
        autocompletion=complete_scenario,
    ),
]
ScanTopic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of the scans; default: /scan.")]
OdomTopic = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Topic of the odometry, where it does not come by /tf; default: /odom."),
]
Mount = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        metavar="X Y THETA", help="Place of the lidar on the base, metres and radians, where /tf_static is silent."
    ),
]
Start = Annotated[
    Literal["search", "saved"], typer.Option(help="Start in that map: search for it, or where the other run ended.")
]
Localize = Annotated[
    bool, typer.Option("--localize", help="Find the robot in that map and track it; the map stays as it is.")
]


@app.callback()
def _ros() -> None:
    """Run as a node of ROS 2. It needs pip install 'hopslam\\[ros]', but no installed ROS."""


@app.command()
def slam(
    scenario: SettingsSource = "replay",
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    foxglove: Foxglove = False,
    foxglove_at: FoxgloveAt = None,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    mount: Mount = None,
    saved_map: SavedMap = None,
    start: Start = "search",
    localize: Localize = False,
) -> None:
    """Map the surroundings of any robot by its scans and odometry, until Ctrl-C.

    The transform from map to odom, /map, /lines and /slam_pose are published; /initialpose is heard. Results are in a
    run folder, as of every run. Domain and reach are those of ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE, this
    machine only where the latter is not set: see docs/ros.md.

    [bold]Examples[/bold]

    hopslam ros slam

    hopslam ros slam --scan-topic /base_scan --set ros.reliable=true

    hopslam ros slam --map runs/latest/map.json --localize --rerun spawn
    """
    from slam.run.launch import follow
    from slam.run.run_and_report import run_and_report

    console = Terminal()
    named = {"ros.scan_topic": scan_topic, "ros.odom_topic": odom_topic}
    settings = [*(settings or ()), *(f"{key}={name}" for key, name in named.items() if name is not None)]
    run_and_report(
        lambda viewers: follow(
            scenario, settings=settings, mount=mount, out=out, saved_map=saved_map, start=start, keep_map=localize,
            allow_modules=allow_modules or (), foxglove=foxglove_at or foxglove, check=False, viewers=viewers,
            console=console,
        ),
        rerun,
        console,
    )  # fmt: skip
