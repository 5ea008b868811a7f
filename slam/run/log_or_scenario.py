"""The source of a run, told by its name: a scenario, or a recorded log."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError, ScenarioError
from slam.files.logs import BagTopics
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario
from slam.scenario.shipped import shipped_scenarios

Settings = str | Sequence[str]
"""``key=value``, one or several."""


def is_recorded(source: str | Path) -> bool:
    """True for a file or folder that is no scenario. A shipped scenario comes before a folder of its name."""
    path = Path(source)
    if path.is_dir():
        return str(source) not in shipped_scenarios()
    return path.is_file() and path.suffix not in {".yaml", ".yml"}


def refuse(kind: str, source: str | Path, **options: Any) -> None:
    """InputError where one of these options is given, which mean nothing for a source of this kind."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name.replace('_', '-')} {value}: {source} is {kind}; leave it out")


def recorded_experiment(
    log: Path, scenario: str | Path | None, settings: Settings, slam: SlamConfig | None, allow_modules: Settings,
    topics: BagTopics, console: Terminal,
) -> Experiment:  # fmt: skip
    """Experiment on the log, bag or run folder at this path; prints what was read."""
    own = log / "config.yaml"
    source = scenario or (own if own.is_file() else "replay")
    experiment = replay_experiment(log, with_slam(load_scenario(source, settings, allow_modules), slam), topics)
    console.print(experiment.notes["log_report"])
    return experiment


def with_slam(scenario: Scenario, slam: SlamConfig | None) -> Scenario:
    """The scenario with these settings of the method in the place of its own; ScenarioError for what are none."""
    if slam is None:
        return scenario
    if not isinstance(slam, SlamConfig):
        raise ScenarioError(f"slam is of type {type(slam).__name__}; give a SlamConfig, or slam.key=value in settings")
    return scenario.model_copy(update={"slam": slam})
