"""Options of several commands, with their shell completion."""

from pathlib import Path
from typing import Annotated

import typer


def complete_scenario(incomplete: str) -> list[str]:
    """Return shipped scenarios whose names begin with the text; without any, the shell offers files."""
    from slam.scenario.shipped import shipped_scenarios

    return [name for name in shipped_scenarios() if name.startswith(incomplete)]


def complete_sweep(incomplete: str) -> list[str]:
    """Return shipped scenarios and sweeps whose names begin with the text."""
    from slam.scenario.shipped import SHIPPED

    sweeps = sorted(path.stem for path in (SHIPPED / "sweeps").glob("*.yaml"))
    return [*complete_scenario(incomplete), *(name for name in sweeps if name.startswith(incomplete))]


ScenarioName = Annotated[
    str,
    typer.Argument(help="Name of a shipped scenario, or a path to a YAML file.", autocompletion=complete_scenario),
]
Seed = Annotated[int | None, typer.Option(help="Seed of all random numbers; default: the scenario's.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change one setting; may be given again.")
]
AllowModules = Annotated[
    list[str] | None,
    typer.Option(
        "--allow-module",
        metavar="NAME",
        help="Allow files to run code of this Python module: see docs/extend.md; may be given again.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for the results; default runs/<name>-<time>, and runs/latest."),
]
Rerun = Annotated[
    list[str] | None,
    typer.Option(
        metavar="WHERE",
        help="Show it in rerun: FILE.rrd, spawn, connect[=HOST:PORT] or serve[=PORT]; may be given again.",
    ),
]
Ros = Annotated[bool, typer.Option("--ros", help="Publish on ROS 2 topics: see docs/topics.md.")]
DrivenByRos = Annotated[
    bool,
    typer.Option(
        "--ros",
        help="Publish the run on ROS 2 topics, and let /cmd_vel drive the robot of a scenario: see docs/topics.md.",
    ),
]
Foxglove = Annotated[
    bool, typer.Option("--foxglove", help="Serve the same topics to the Foxglove app: see docs/topics.md.")
]
FoxgloveAt = Annotated[
    str | None,
    typer.Option(
        metavar="[HOST:]PORT", help="Address at which Foxglove is served; default: port 8765, for this machine only."
    ),
]
Pace = Annotated[
    float | None,
    typer.Option(
        metavar="X",
        help="With topics: speed relative to real time; inf: as fast as possible; 0: one scan per command. Default: 1.",
    ),
]
Yes = Annotated[bool, typer.Option("--yes", help="The real robot moves without asking first.")]
RecordWire = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Append every byte that passes over the ports to FILE, with times: see hopslam wire."
    ),
]
ScanTopic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of a bag's scans, if it has several.")]
OdomTopic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of a bag's odometry, if it has several.")]
SavedMap = Annotated[Path | None, typer.Option("--map", metavar="FILE", help="Continue the map.json of another run.")]
Lenient = Annotated[bool, typer.Option("--lenient", help="Exit with 0 even if most scans of a log are lost.")]
