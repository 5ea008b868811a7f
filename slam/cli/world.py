"""``hopslam world``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import ScenarioName, Settings


def world(
    scenario: ScenarioName,
    seed: Annotated[int | None, typer.Option(help="Seed of all that is random; default: the scenario's.")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The picture: .png, .svg or .pdf; default <name>.png.")
    ] = None,
    settings: Settings = None,
) -> None:
    """Draw the world of a scenario, and what moves in it.

    Dark is what the lidar sees, light what is lower or higher than its plane; the start pose, the route and the ways of
    people are drawn over it. Metres, map frame.

    [bold]Examples[/bold]

    hopslam world office_loop

    hopslam world random_office --seed 7 --out office7.png

    hopslam world replay --set generate.kind=corridor --set generate.width=3 --out corridor.svg
    """
    from slam.cli.inputs import draw_with_warnings, with_seed
    from slam.run.pictures.world_picture import check_picture, draw_world
    from slam.scenario.file import read_template, summary

    loaded = draw_with_warnings(read_template(scenario, with_seed(settings, seed)))
    path = out or Path(f"{loaded.name}.png")
    check_picture(path)
    draw_world(path, loaded)
    typer.echo(f"{summary(loaded)}\ndrawn in {path}")
