"""The command line: ``hopslam``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer
from rich.console import Console

from slam.errors import HopslamError, InputError
from slam.run.bench.cli import app as bench
from slam.run.calibrate_cli import app as calibrate
from slam.run.env_cli import env
from slam.run.hardware_cli import doctor, emulate
from slam.run.lines_cli import lines
from slam.run.localize_cli import localize
from slam.run.sweep_cli import app as sweep
from slam.run.world_cli import world

app = typer.Typer(
    help="A robot testbed for line-based SLAM with a cheap 2-D lidar.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    add_completion=False,
)
app.command()(lines)
app.command()(localize)
app.command()(env)
app.command()(world)
app.command()(emulate)
app.command()(doctor)
app.add_typer(bench, name="bench")
app.add_typer(calibrate, name="calibrate")
app.add_typer(sweep, name="sweep")
console = Console()

Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change one setting; may be given again.")
]
Out = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for the results; default runs/<name>-<time>, and runs/latest."),
]
Rerun = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Record for the rerun viewer: into this .rrd file, and the results' run.rrd."),
]

SavedMap = Annotated[
    Path | None, typer.Option("--map", metavar="FILE", help="Go on mapping in this map.json of another run.")
]


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        console.print(f"hopslam {version('hopslam')}", highlight=False)
        raise typer.Exit


@app.callback()
def _hopslam(
    version: Annotated[bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show it.")] = False,
) -> None:
    """A robot testbed for line-based SLAM with a cheap 2-D lidar."""


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="Name of a shipped scenario, or a path to a YAML file.")] = "corridor",
    seed: Annotated[int | None, typer.Option(help="Seed of all that is random; default: the scenario's.")] = None,
    out: Out = None,
    settings: Settings = None,
    rerun: Rerun = None,
    backend: Annotated[str, typer.Option(metavar="NAME", help="sim, or hardware: the real robot.")] = "sim",
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
    from slam.run.experiment import scenario_experiment
    from slam.run.finish import finish
    from slam.run.scenario.file import load_scenario

    if backend == "replay":
        raise InputError("--backend replay has no log to play; run: hopslam replay LOG")
    if backend != "hardware" and (yes or dry_run):
        raise InputError("--yes and --dry-run are for the real robot; add --backend hardware")
    by_seed = [] if seed is None else [f"seed={seed}"]
    options = {"yes": yes, "dry_run": dry_run} if backend == "hardware" else {}
    experiment = scenario_experiment(load_scenario(scenario, [*(settings or []), *by_seed]), backend, **options)
    if saved_map is not None:
        from slam.run.localization import continued

        experiment = continued(experiment, saved_map, start)
    finish(experiment.run(out, rerun, console))


@app.command()
def replay(
    log: Annotated[Path, typer.Argument(help="A CARMEN log, a URG-04LX text log, both maybe gzipped, or a ROS 1 bag.")],
    scenario: Annotated[str, typer.Option(help="Where the settings of the method come from.")] = "replay",
    out: Out = None,
    settings: Settings = None,
    rerun: Rerun = None,
    saved_map: SavedMap = None,
    start: Annotated[
        Literal["search", "saved"], typer.Option(help="Where in that map: to be found, or where the other run ended.")
    ] = "search",
) -> None:
    """Map a recorded log of a real robot.

    [bold]Examples[/bold]

    hopslam replay fr079.log.gz

    hopslam replay mines1.dat.gz --out /tmp/mines --set slam.update_distance=0.1

    hopslam replay second_half.log --map runs/latest/map.json --start saved
    """
    from slam.run.experiment import replay_experiment
    from slam.run.finish import finish
    from slam.run.scenario.file import load_scenario

    experiment = replay_experiment(log, load_scenario(scenario, settings or []))
    console.print(experiment.notes["log_report"], highlight=False)
    if saved_map is not None:
        from slam.run.localization import continued

        experiment = continued(experiment, saved_map, start)
    finish(experiment.run(out, rerun, console))


def _fail(error: HopslamError) -> NoReturn:
    print(f"hopslam: {error}", file=sys.stderr)
    raise SystemExit(error.exit_code)


def _interrupt(*_: Any) -> NoReturn:
    raise KeyboardInterrupt


def main() -> None:
    """Run the command line; known errors are one line and an exit code: 2 bad input, 3 a device, 130 Ctrl-C."""
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        app()
    except HopslamError as error:
        _fail(error)
    except KeyboardInterrupt:
        raise SystemExit(130) from None
