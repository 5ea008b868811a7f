"""``hopslam world`` and ``hopslam schema``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import ScenarioName, Seed, Settings
from slam.console.terminal import Terminal


def world(
    scenario: ScenarioName,
    seed: Seed = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The picture: .png, .svg or .pdf; default <name>.png.")
    ] = None,
    settings: Settings = None,
) -> None:
    """Draw the world of a scenario, with people and movable furniture.

    Solids that the lidar sees are dark, those below or above its plane light; the start pose, the route and the paths
    of people are drawn over it. Metres, map frame.

    [bold]Examples[/bold]

    hopslam world office_loop

    hopslam world random_office --seed 7 --out office7.png

    hopslam world replay --set generate.kind=corridor --set generate.width=3 --out corridor.svg
    """
    from slam.run.pictures.world_picture import check_picture, draw_world
    from slam.scenario.file import read_template, summary
    from slam.scenario.settings import with_seed

    template = read_template(scenario, with_seed(settings or (), seed))
    loaded = template.draw()
    Terminal().warn(*template.warnings(loaded))
    path = out or Path(f"{loaded.name}.png")
    check_picture(path)
    draw_world(path, loaded)
    typer.echo(f"{summary(loaded)}\ndrawn in {path}")


def schema() -> None:
    """Print the JSON schema of scenario files, with which editors complete and check them.

    The schema of this version is also in scenarios/scenario.schema.json. The first line of a scenario names its schema:
    # yaml-language-server: $schema=PATH.

    [bold]Examples[/bold]

    hopslam schema > scenario.schema.json
    """
    from slam.scenario.json_schema import schema_text

    typer.echo(schema_text(), nl=False)
