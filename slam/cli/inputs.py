"""Inputs of commands: scenarios, with warnings about strange values, and recorded runs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slam.console.terminal import Terminal

if TYPE_CHECKING:
    from slam.files.logs import BagTopics
    from slam.run.experiment import Experiment
    from slam.run.results.run_record import RunRecord
    from slam.scenario.schema import Scenario
    from slam.scenario.template import ScenarioTemplate


def with_seed(settings: Sequence[str] | None, seed: int | None) -> list[str]:
    """Settings of a scenario, with those of ``--seed`` where it is given."""
    return [*(settings or []), *([] if seed is None else [f"seed={seed}"])]


def draw_with_warnings(template: ScenarioTemplate) -> Scenario:
    """Draw the scenario of the template's own seed; warn of strange values on standard error, a line each."""
    scenario = template.draw()
    for caution in template.warnings(scenario):
        print(f"hopslam: warning: {caution}", file=sys.stderr)
    return scenario


def recorded_experiment(
    log: Path,
    scenario: str | None,
    settings: Sequence[str],
    allow_modules: Sequence[str],
    topics: BagTopics,
    console: Terminal,
) -> Experiment:
    """Experiment on the log, bag or run folder at this path; prints what was read.

    The settings of the method are those of a scenario: by default the run's own, or ``replay``.
    """
    from slam.run.experiment_setup import replay_experiment
    from slam.scenario.file import load_scenario

    own = log / "config.yaml"
    source = scenario or (own if own.is_file() else "replay")
    experiment = replay_experiment(log, load_scenario(source, settings, allow_modules), topics)
    console.print(experiment.notes["log_report"])
    return experiment


def warn_of_damage(records: Sequence[RunRecord]) -> None:
    """Name the damaged files of the runs on standard error, a line each."""
    for record in records:
        for damage in record.damage:
            print(f"hopslam: warning: {damage}; what comes after that is left out", file=sys.stderr)
