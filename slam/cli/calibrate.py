"""``hopslam calibrate``: wheel sizes and track, from driven squares."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slam.console.options import AllowModules, ScenarioName, Settings, complete_scenario
from slam.errors import InputError

if TYPE_CHECKING:
    from slam.console.terminal import Terminal
    from slam.run.calibration.calibrate import Calibration
    from slam.run.calibration.square import Square
    from slam.scenario.schema import Scenario

app = typer.Typer(no_args_is_help=True, add_completion=False)


@app.callback()
def _calibrate() -> None:
    """Find what the wheels really are, by driving."""


@app.command()
def square(
    scenario: ScenarioName = "umbmark_room",
    size: Annotated[float, typer.Option(min=0.5, max=10.0, metavar="M", help="Side of the squares, metres.")] = 2.0,
    laps: Annotated[int, typer.Option(min=1, max=50, help="Squares to the right, and as many to the left.")] = 2,
    speed: Annotated[float, typer.Option(min=0.05, max=1.0, metavar="M/S", help="On the sides.")] = 0.3,
    onto: Annotated[
        str | None,
        typer.Option(
            metavar="SCENARIO",
            help="What the file extends; default: the scenario itself.",
            autocompletion=complete_scenario,
        ),
    ] = None,
    out: Annotated[Path, typer.Option(metavar="FILE", help="A scenario with the right wheels.")] = Path("wheels.yaml"),
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The squares before and after; default: beside the file, .png.")
    ] = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    backend: Annotated[str, typer.Option(metavar="NAME", help="sim, or hardware: the real robot.")] = "sim",
    yes: Annotated[bool, typer.Option("--yes", help="The real robot moves without asking first.")] = False,
) -> None:
    """Drive UMBmark's squares both ways, and fit both wheels and the track to where the robot really went.

    That is known in the simulator; on the real robot it is what SLAM says. The squares lie to the right and to the left
    ahead of the robot, and need as much room. The file is a scenario: run it, extend it, or give its keys with --set.

    [bold]Examples[/bold]

    hopslam calibrate square

    hopslam calibrate square --size 1 --laps 5 --onto corridor --out corridor_right.yaml

    hopslam calibrate square --backend hardware --set hardware.robot_port=/tmp/robot/p3dx --set
    hardware.lidar_port=/tmp/robot/urg04lx

    hopslam run wheels.yaml
    """
    from slam.console.terminal import Terminal
    from slam.run.calibration.calibrate import require_backend
    from slam.run.calibration.report import draw_squares, extends_value, summary, write_wheels
    from slam.run.calibration.square import Square
    from slam.run.pictures.world_picture import check_picture
    from slam.run.warm_up import warm_up
    from slam.scenario.file import load_scenario

    require_backend(backend)
    if yes and backend == "sim":
        raise InputError("--yes is for the real robot; add --backend hardware")
    base = extends_value(onto or scenario)
    drawn = picture or out.with_suffix(".png")
    check_picture(drawn)
    loaded = load_scenario(scenario, settings or [], allow_modules or [])
    console = Terminal()
    warm_up(console, loaded.slam)
    found = _driven(loaded, Square(size, laps, speed), backend, yes, console)
    write_wheels(out, base, loaded, backend, found)
    draw_squares(drawn, found)
    console.print(summary(found))
    console.print(f"wheels in {out}, squares in {drawn}")


def _driven(scenario: Scenario, path: Square, backend: str, yes: bool, console: Terminal) -> Calibration:
    """Drive the squares, with a progress bar."""
    from slam.run.calibration.calibrate import calibrate

    legs = len(list(path.turns)) * 2
    options = {"yes": yes} if backend == "hardware" else {}
    with console.progress("{task.completed}/{task.total} legs", transient=True) as bar:
        task = bar.add_task("driving squares", total=legs)
        return calibrate(scenario, path, backend, lambda done: bar.update(task, completed=done), **options)
