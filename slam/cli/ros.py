"""``hopslam ros``: SLAM as a node of ROS 2."""

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
    typer.Option(metavar="NAME", help="Topic of the odometry, if it is not in /tf; default: /odom."),
]
Mount = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        metavar="X Y THETA", help="Pose of the lidar on the base, metres and radians, if /tf_static has none."
    ),
]
Start = Annotated[
    Literal["search", "saved"],
    typer.Option(help="Start in the map of --map; search: anywhere; saved: at the last pose of the other run."),
]
Localize = Annotated[
    bool, typer.Option("--localize", help="Localise the robot in the map of --map, which does not change.")
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
    """Map the surroundings of any robot from its scans and odometry; Ctrl-C ends it.

    It publishes the transform from map to odom, /map, /lines and /slam_pose, and subscribes to /initialpose. Results
    are in a run folder, as for every run. ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE choose the network, by
    default this machine only: see docs/ros.md.

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
