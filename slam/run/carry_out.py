"""Runs an experiment for a command or a program: on its topics, in its viewers, with its warnings."""

from collections.abc import Sequence
from pathlib import Path

from slam.console.terminal import Terminal
from slam.run.experiment import Experiment
from slam.run.experiment_setup import on_topics
from slam.run.log_or_scenario import path_of
from slam.run.run import Run
from slam.run.topics.topic_choice import TopicChoice
from slam.run.viewer.viewers import Viewers


def carry_out(
    experiment: Experiment, out: str | Path | None, rerun: str | Sequence[str], choice: TopicChoice, pictures: bool,
    check: bool, lenient: bool, viewers: Viewers | None, console: Terminal,
) -> Run:  # fmt: skip
    """Run the experiment, published on its topics and shown in the given viewers, or in those of ``rerun``."""
    if viewers is None:
        with Viewers(rerun, console) as own:
            return carry_out(experiment, out, (), choice, pictures, check, lenient, own, console)
    folder = None if out is None else path_of("out", out)
    with choice.session(console) as topics:
        experiment = experiment if topics is None else on_topics(experiment, topics)
        made = Run.of(experiment.run(folder, viewers, console, pictures), experiment.loss)
    if check:
        console.warn(*made.warnings)
        made.require_success(lenient)
    return made
