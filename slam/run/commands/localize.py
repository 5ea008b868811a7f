"""``hopslam localize``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slam.errors import InputError
from slam.run.commands.options import Out, Rerun, Settings
from slam.run.terminal import Terminal

if TYPE_CHECKING:
    from slam.run.experiment import Experiment


def localize(
    source: Annotated[
        str, typer.Argument(metavar="LOG|SCENARIO", help="A recorded log, or a scenario by name or YAML file.")
    ],
    saved_map: Annotated[Path, typer.Option("--map", metavar="FILE", help="The map.json of another run.")],
    seed: Annotated[int | None, typer.Option(help="Of a scenario: of all that is random; default: its own.")] = None,
    scenario: Annotated[
        str | None, typer.Option(help="Of a log: where the settings of the method come from; default: replay.")
    ] = None,
    out: Out = None,
    settings: Settings = None,
    rerun: Rerun = None,
) -> None:
    """Find the robot in a saved map, from nothing, and track it. The map stays as it is.

    A simulated robot wanders until it is sure of its place, and then drives the scenario's route.

    [bold]Examples[/bold]

    hopslam run office_loop --out /tmp/office

    hopslam localize office_loop --map /tmp/office/map.json --seed 7 --set robot.start.x=3 --set robot.start.theta=2

    hopslam localize fr079.log.gz --map runs/latest/map.json --set slam.localization.hypotheses=100
    """
    from slam.run.conduct import conduct
    from slam.run.localization import localized

    console = Terminal()
    experiment = localized(_experiment(source, scenario, settings or [], seed, console), saved_map)
    conduct(experiment, out, rerun, console)


def _experiment(
    source: str, scenario: str | None, settings: list[str], seed: int | None, console: Terminal
) -> Experiment:
    """Of a scenario where the source is one, of a log where it is another file."""
    from slam.run.experiment import replay_experiment, scenario_experiment
    from slam.run.scenario.file import load_scenario

    path = Path(source)
    if path.is_file() and path.suffix not in {".yaml", ".yml"}:
        experiment = replay_experiment(path, load_scenario(scenario or "replay", settings))
        console.print(experiment.notes["log_report"])
        return experiment
    if scenario is not None:
        raise InputError(f"--scenario {scenario}: {source} is one itself, and no log; leave it out")
    by_seed = [] if seed is None else [f"seed={seed}"]
    return scenario_experiment(load_scenario(source, [*settings, *by_seed]))
