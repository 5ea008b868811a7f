"""``hopslam eval``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from slam.console.terminal import Terminal
from slam.console.terminal_table import TerminalTable
from slam.errors import InputError

if TYPE_CHECKING:
    from slam.run.scoring.evaluate import Score

Reference = Annotated[
    Path | None, typer.Option(metavar="FILE.tum", help="The true trajectory; default: the run's groundtruth.tum.")
]
Relations = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Relations of Kuemmerle et al.: t1 t2 x y z roll pitch yaw.")
]
MaxGap = Annotated[
    float, typer.Option(min=0.0, help="Seconds to the nearest pose, at most, where one is interpolated.")
]


def evaluate(
    run: Annotated[Path, typer.Argument(metavar="RUN|FILE.tum", help="The folder of a run, or a TUM trajectory.")],
    reference: Reference = None,
    relations: Relations = None,
    delta: Annotated[float, typer.Option(min=0.01, help="The relative error is taken over so much ...")] = 1.0,
    delta_unit: Annotated[
        Literal["m", "frames"], typer.Option(help="... of the true path, in metres, or of poses.")
    ] = "m",
    align: Annotated[bool, typer.Option(help="Align the trajectories rigidly before the absolute error.")] = True,
    max_gap: MaxGap = 1.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, metres and radians, and no table.")] = False,
) -> None:
    """Score a trajectory: absolute and relative error against a reference, or the relations metric.

    Of a run, that of the poses as they were known on the way, and again as they are known with its loops closed.

    [bold]Examples[/bold]

    hopslam eval runs/latest

    hopslam eval runs/latest --reference fr079.gt.tum --delta 10

    hopslam eval other_slam.tum --reference fr079.gt.tum --delta 1 --delta-unit frames --no-align

    hopslam eval runs/latest --json

    hopslam eval runs/latest --relations fr079.relations.gz --max-gap 10
    """
    from slam.run.scoring import evaluate as scoring

    if delta_unit == "frames" and delta < 1.0:
        raise InputError(f"--delta {delta:g}: the next pose is 1 frame away; give --delta 1 or more")
    scores: list[Score] = []
    for name, estimate in scoring.trajectories_to_score(run).items():
        own: list[Score] = []
        if reference is not None or relations is None:
            true = scoring.read_trajectory(scoring.reference_of(run, reference))
            pieces = scoring.Delta(delta, delta_unit)
            own.extend(scoring.against_reference(estimate, true, pieces, align, max_gap))
        if relations is not None:
            own.append(scoring.against_relations(estimate, relations, max_gap))
        scores += [score._replace(name=name + score.name) for score in own]
    typer.echo(_json(scores)) if as_json else Terminal().print(_table(scores))


def _json(scores: list[Score]) -> str:
    """An object a score, by its name."""
    from slam.run.scoring.evaluate import statistics

    values = {
        score.name: {
            "metres": statistics(score.errors.metres) if len(score.errors.metres) else None,
            "radians": statistics(score.errors.radians) if len(score.errors.radians) else None,
            "used": len(score.errors.metres),
            "of": score.asked,
        }
        for score in scores
    }
    return json.dumps(values, indent=2)


def _table(scores: list[Score]) -> TerminalTable:
    """A row for the translation of each score, and one for its rotation."""
    from numpy import degrees

    from slam.run.scoring.evaluate import statistics

    columns = ("mean", "std", "rmse", "median", "max")
    rows = []
    for name, errors, asked in scores:
        used = f"{len(errors.metres)} of {asked}"
        for unit, values in (("m", statistics(errors.metres)), ("deg", statistics(degrees(errors.radians)))):
            rows.append((f"{name} [{unit}]", *(f"{values[column]:.4f}" for column in columns), used))
    return TerminalTable(("", *columns, "used"), rows)
