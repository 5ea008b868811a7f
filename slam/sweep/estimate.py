"""How long a sweep takes, before it is started."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Final

from slam.console.terminal import Terminal
from slam.run.loop import run_loop
from slam.run.step import Step
from slam.run.warm_up import warm_up
from slam.sweep.job import Job
from slam.sweep.run_job import experiment_of

_LOOK: Final = 2.0
"""Seconds for which a run is timed."""


@dataclass
class _Glance:
    """A watcher that ends a run when it has been looked at for long enough."""

    began: float
    share: float = 0.0
    """Of the run that is over."""

    def on_step(self, step: Step) -> None:
        self.share = step.progress
        if perf_counter() - self.began > _LOOK:
            raise KeyboardInterrupt


def seconds_of(job: Job, allowed: Sequence[str]) -> float:
    """What one run of this job takes, from its first two seconds; InputError where it cannot be run at all."""
    experiment = experiment_of(job, allowed)
    experiment.env.prepare(job.seed)
    warm_up(Terminal(quiet=True), experiment.scenario.slam)
    glance = _Glance(perf_counter())
    try:
        run_loop(experiment.env, experiment.slam, experiment.pilot, [glance], experiment.seed)
    except KeyboardInterrupt:
        pass
    finally:
        experiment.env.close()
    taken = perf_counter() - glance.began
    return taken / glance.share if 0.0 < glance.share < 1.0 else taken
