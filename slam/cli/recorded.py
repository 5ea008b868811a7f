"""A recorded run as an experiment: what ``hopslam replay`` and ``hopslam localize`` take."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slam.console.terminal import Terminal

if TYPE_CHECKING:
    from slam.files.logs import BagTopics
    from slam.run.experiment import Experiment


def recorded_experiment(
    log: Path,
    scenario: str | None,
    settings: Sequence[str],
    allow_modules: Sequence[str],
    topics: BagTopics,
    console: Terminal,
) -> Experiment:
    """The log, bag or run folder at this path, with the settings of the method from a scenario: by default the run's
    own, or ``replay``. Prints what was read."""
    from slam.run.experiment_setup import replay_experiment
    from slam.scenario.file import load_scenario

    own = log / "config.yaml"
    source = scenario or (own if own.is_file() else "replay")
    experiment = replay_experiment(log, load_scenario(source, settings, allow_modules), topics)
    console.print(experiment.notes["log_report"])
    return experiment
