"""``hopslam eval``."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from slam.console.terminal import Terminal
from slam.errors import InputError

Reference = Annotated[
    Path | None, typer.Option(metavar="FILE.tum", help="The true trajectory; default: the run's groundtruth.tum.")
]
Relations = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Known relative poses (relations): t1 t2 x y z roll pitch yaw.")
]
MaxGap = Annotated[float, typer.Option(min=0.0, help="Longest gap between poses, seconds, that is interpolated.")]


def evaluate(
    run: Annotated[Path, typer.Argument(metavar="RUN|FILE.tum", help="The folder of a run, or a TUM trajectory.")],
    reference: Reference = None,
    relations: Relations = None,
    delta: Annotated[float, typer.Option(min=0.01, help="Length of the pieces for the relative error.")] = 1.0,
    delta_unit: Annotated[
        Literal["m", "frames"], typer.Option(help="Unit of --delta: metres of the true path, or poses.")
    ] = "m",
    align: Annotated[bool, typer.Option(help="Align the trajectories rigidly before the absolute error.")] = True,
    max_gap: MaxGap = 1.0,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON, metres and radians, instead of a table.")
    ] = False,
) -> None:
    """Score a trajectory against a reference, by absolute and relative error, or against known relative poses.

    A run is scored twice: with the poses as estimated during the run, and with the final ones after loop closing.

    [bold]Examples[/bold]

    hopslam eval runs/latest

    hopslam eval runs/latest --reference fr079.gt.tum --delta 10

    hopslam eval other_slam.tum --reference fr079.gt.tum --delta 1 --delta-unit frames --no-align

    hopslam eval runs/latest --json

    hopslam eval runs/latest --relations fr079.relations.gz --max-gap 10
    """
    from slam.run.scoring.evaluate import evaluate as score

    if delta_unit == "frames" and delta < 1.0:
        raise InputError(f"--delta {delta:g}: the next pose is 1 frame away; give --delta 1 or more")
    scores = score(
        run, reference, relations=relations, delta=delta, delta_unit=delta_unit, align=align, max_gap=max_gap
    )
    if as_json:
        typer.echo(json.dumps(scores.as_dict(), indent=2))
    else:
        Terminal().print(scores.table().for_terminal())
