"""The source of a run, recognised from its name: a scenario, or a recorded log."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slam.config import SlamConfig
from slam.console.terminal import Terminal
from slam.errors import InputError, ScenarioError, shown
from slam.files.logs import BagTopics
from slam.run.experiment import Experiment
from slam.run.experiment_setup import replay_experiment
from slam.scenario.file import load_scenario
from slam.scenario.schema import Scenario
from slam.scenario.shipped import shipped_scenarios

Settings = str | Sequence[str]
"""One or several ``key=value``."""


def is_recorded(source: str | Path) -> bool:
    """Return True for a file or folder that is not a scenario.

    A shipped scenario has priority over a folder of its name.
    """
    path = path_of("source", source)
    if path.is_dir():
        return str(source) not in shipped_scenarios()
    return path.is_file() and path.suffix not in {".yaml", ".yml"}


def path_of(argument: str, value: str | Path) -> Path:
    """Return the path that a caller gave for this argument; InputError for anything else."""
    if not isinstance(value, str | Path):
        raise InputError(f"{argument}: expected a path (got {shown(value)})")
    return Path(value)


def refuse(kind: str, source: str | Path, **options: Any) -> None:
    """Raise InputError if one of these options is given, which have no meaning for this kind of source."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name.replace('_', '-')} {value}: {source} is {kind}; leave it out")


def recorded_experiment(
    log: Path, scenario: str | Path | None, settings: Settings, slam: SlamConfig | None, allow_modules: Settings,
    topics: BagTopics, console: Terminal,
) -> Experiment:  # fmt: skip
    """Make the experiment of the log, bag or run folder at this path; print what was read."""
    own = log / "config.yaml"
    source = scenario or (own if own.is_file() else "replay")
    experiment = replay_experiment(log, with_slam(load_scenario(source, settings, allow_modules), slam), topics)
    console.print(experiment.notes["log_report"])
    return experiment


def with_slam(scenario: Scenario, slam: SlamConfig | None) -> Scenario:
    """Return the scenario with these settings of the method instead of its own; ScenarioError for invalid ones."""
    if slam is None:
        return scenario
    if not isinstance(slam, SlamConfig):
        raise ScenarioError(f"slam is of type {type(slam).__name__}; give a SlamConfig, or slam.key=value in settings")
    return scenario.model_copy(update={"slam": slam})
