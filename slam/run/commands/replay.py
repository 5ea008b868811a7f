"""``hopslam replay``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from slam.run.commands.options import Out, Rerun, SavedMap, Settings
from slam.run.terminal import Terminal


def replay(
    log: Annotated[
        Path,
        typer.Argument(
            help="A CARMEN log or a URG-04LX text log, both maybe gzipped; a bag of ROS 1, the folder of one of ROS 2, "
            "an MCAP file; or the folder of a run."
        ),
    ],
    scenario: Annotated[
        str | None, typer.Option(help="Where the settings of the method come from; default: the run's own, or replay.")
    ] = None,
    out: Out = None,
    settings: Settings = None,
    rerun: Rerun = None,
    saved_map: SavedMap = None,
    start: Annotated[
        Literal["search", "saved"], typer.Option(help="Where in that map: to be found, or where the other run ended.")
    ] = "search",
    scan_topic: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of a bag: the topic of the scans, where there are several."),
    ] = None,
    odom_topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of a bag: the topic of the odometry, likewise.")
    ] = None,
) -> None:
    """Map a recorded log of a robot, or a run once more.

    [bold]Examples[/bold]

    hopslam replay fr079.log.gz

    hopslam replay mines1.dat.gz --out /tmp/mines --set slam.update_distance=0.1

    hopslam replay robot.bag --scan-topic /base_scan --odom-topic /odom

    hopslam replay runs/latest --set slam.deskew=false

    hopslam replay second_half.log --map runs/latest/map.json --start saved
    """
    from slam.run.conduct import conduct
    from slam.run.experiment import replay_experiment
    from slam.run.logs import BagTopics
    from slam.run.scenario.file import load_scenario

    console = Terminal()
    own = log / "config.yaml"
    source = scenario or (own if own.is_file() else "replay")
    experiment = replay_experiment(log, load_scenario(source, settings or []), BagTopics(scan_topic, odom_topic))
    console.print(experiment.notes["log_report"])
    if saved_map is not None:
        from slam.run.localization import continued

        experiment = continued(experiment, saved_map, start)
    conduct(experiment, out, rerun, console)
