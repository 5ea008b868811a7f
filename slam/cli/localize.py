"""``hopslam localize``."""

from pathlib import Path
from typing import Annotated

import typer

from slam.console.options import AllowModules, Lenient, OdomTopic, Out, Rerun, ScanTopic, Settings, complete_scenario
from slam.console.terminal import Terminal
from slam.errors import InputError

Source = Annotated[
    str,
    typer.Argument(
        metavar="LOG|SCENARIO",
        help="What hopslam replay takes: a log, a bag or a run folder; or a scenario.",
        autocompletion=complete_scenario,
    ),
]
SettingsSource = Annotated[
    str | None,
    typer.Option(
        help="Of a log: where the settings of the method come from; default: the run's own, or replay.",
        autocompletion=complete_scenario,
    ),
]


def localize(
    source: Source,
    saved_map: Annotated[Path, typer.Option("--map", metavar="FILE", help="The map.json of another run.")],
    seed: Annotated[int | None, typer.Option(help="Of a scenario: of all that is random; default: its own.")] = None,
    scenario: SettingsSource = None,
    out: Out = None,
    settings: Settings = None,
    allow_modules: AllowModules = None,
    rerun: Rerun = None,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    lenient: Lenient = False,
) -> None:
    """Find the robot in a saved map, from nothing, and track it. The map stays as it is.

    A simulated robot wanders until it is sure of its place, and then drives the scenario's route.

    [bold]Examples[/bold]

    hopslam run office_loop --out /tmp/office

    hopslam localize office_loop --map /tmp/office/map.json --seed 7 --set robot.start.x=3 --set robot.start.theta=2

    hopslam localize fr079.log.gz --map runs/latest/map.json --set slam.localization.hypotheses=100

    hopslam localize runs/latest --map /tmp/office/map.json
    """
    from slam.cli.inputs import recorded_experiment, with_seed
    from slam.files.logs import BagTopics
    from slam.run.experiment_setup import localize_in_map, scenario_experiment
    from slam.run.run_and_report import run_and_report
    from slam.scenario.file import load_scenario

    console, allowed, topics = Terminal(), allow_modules or [], BagTopics(scan_topic, odom_topic)
    if _is_recorded(source):
        _refuse("a recorded log, in which nothing is random", source, seed=seed)
        experiment = recorded_experiment(Path(source), scenario, settings or [], allowed, topics, console)
    else:
        _refuse("a scenario, and no log", source, scenario=scenario, scan_topic=scan_topic, odom_topic=odom_topic)
        experiment = scenario_experiment(load_scenario(source, with_seed(settings, seed), allowed))
    run_and_report(localize_in_map(experiment, saved_map), out, rerun, console, lenient)


def _is_recorded(source: str) -> bool:
    """True for a file or folder that is no scenario. A shipped scenario comes before a folder of its name."""
    from slam.scenario.shipped import shipped_scenarios

    path = Path(source)
    if path.is_dir():
        return source not in shipped_scenarios()
    return path.is_file() and path.suffix not in {".yaml", ".yml"}


def _refuse(kind: str, source: str, **options: object) -> None:
    """InputError where one of these options is given, which mean nothing for a source of this kind."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name.replace('_', '-')} {value}: {source} is {kind}; leave it out")
