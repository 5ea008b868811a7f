"""``hopslam calibrate``: wheel sizes and track, from driven squares."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slam.console.options import AllowModules, ScenarioName, Settings, Yes, complete_scenario
from slam.console.terminal import Terminal
from slam.errors import InputError

if TYPE_CHECKING:
    from slam.run.calibration.calibrate import Calibration
    from slam.run.calibration.square import Square
    from slam.scenario.schema import Scenario

app = typer.Typer(no_args_is_help=True, add_completion=False)
console = Terminal()

Onto = Annotated[
    str | None,
    typer.Option(
        metavar="SCENARIO",
        help="Scenario that the written file extends; default: the driven one.",
        autocompletion=complete_scenario,
    ),
]
Picture = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Picture of the squares before and after; default: the name of --out with .png."),
]


@app.callback()
def _calibrate() -> None:
    """Measure the true radii and the track of the wheels by driving."""


@app.command()
def square(
    scenario: ScenarioName = "umbmark_room",
    size: Annotated[float, typer.Option(min=0.5, max=10.0, metavar="M", help="Side of the squares, metres.")] = 2.0,
    laps: Annotated[
        int, typer.Option(min=1, max=50, help="Number of squares to the right, and of squares to the left.")
    ] = 2,
    speed: Annotated[float, typer.Option(min=0.05, max=1.0, metavar="M/S", help="Speed on the sides, m/s.")] = 0.3,
    onto: Onto = None,
    out: Annotated[Path, typer.Option(metavar="FILE", help="File for the scenario with the calibrated wheels.")] = Path(
        "wheels.yaml"
    ),
    picture: Picture = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    backend: Annotated[str, typer.Option(metavar="NAME", help="sim, or hardware: the real robot.")] = "sim",
    yes: Yes = False,
) -> None:
    """Drive UMBmark's squares in both directions, and fit wheel radii and track to the robot's true path.

    The true path is known in the simulator; on the real robot SLAM estimates it. The squares lie ahead of the robot, to
    its right and to its left. The written file is a scenario: run it, extend it, or give its keys with --set.

    [bold]Examples[/bold]

    hopslam calibrate square

    hopslam calibrate square --size 1 --laps 5 --onto corridor --out corridor_right.yaml

    hopslam calibrate square --backend hardware --set hardware.robot_port=/tmp/robot/p3dx --set
    hardware.lidar_port=/tmp/robot/urg04lx

    hopslam run wheels.yaml
    """
    from slam.run.calibration.report import extends_value
    from slam.run.calibration.square import Square
    from slam.run.pictures.world_picture import check_picture
    from slam.scenario.file import load_scenario

    _check_backend(backend, yes)
    base, drawn = extends_value(onto or scenario), picture or out.with_suffix(".png")
    check_picture(drawn)
    loaded = load_scenario(scenario, settings or [], allow_modules or [])
    found = _driven(loaded, Square(size, laps, speed), backend, yes)
    _write_results(found, loaded, backend, base, out, drawn)


def _check_backend(backend: str, yes: bool) -> None:
    from slam.run.calibration.calibrate import require_backend

    require_backend(backend)
    if yes and backend == "sim":
        raise InputError("--yes is for the real robot; add --backend hardware")


def _driven(scenario: Scenario, path: Square, backend: str, yes: bool) -> Calibration:
    """Drive the squares, with a progress bar."""
    from slam.run.calibration.calibrate import calibrate
    from slam.run.warm_up import warm_up

    warm_up(console, scenario.slam)
    options = {"yes": yes} if backend == "hardware" else {}
    with console.progress("{task.completed}/{task.total} legs", transient=True) as bar:
        task = bar.add_task("driving squares", total=2 * len(list(path.turns)))
        return calibrate(scenario, path, backend, lambda done: bar.update(task, completed=done), **options)


def _write_results(found: Calibration, scenario: Scenario, backend: str, base: str, out: Path, picture: Path) -> None:
    from slam.run.calibration.report import draw_squares, summary, write_wheels

    write_wheels(out, base, scenario, backend, found)
    draw_squares(picture, found)
    console.print(summary(found))
    console.print(f"wheels in {out}, squares in {picture}")
