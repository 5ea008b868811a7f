"""The runs to look at first, and what repeats them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from typing import Final

from slam.sweep.report.groups import Group

_MOST: Final = 10
"""Runs that are named."""


@dataclass(frozen=True, slots=True)
class NamedRun:
    """A run, and why it is named."""

    id: str
    case: str
    reason: str
    command: str


def worst_runs(groups: list[Group], metric: str) -> list[NamedRun]:
    """The runs with the largest values, over all cases, the largest first."""
    runs = [
        (value, NamedRun(run, f"{group.whole_label}, seed {seed}", f"{metric} {value:.3g}", command))
        for group in groups
        for value, seed, (run, command) in zip(group.values, group.seeds, group.commands, strict=True)
    ]
    return [run for _, run in sorted(runs, key=lambda run: -run[0])[:_MOST]]


def failed_runs(groups: list[Group]) -> list[NamedRun]:
    """Runs without a result, and what they ended with."""
    runs = (
        NamedRun(run, group.whole_label, error, command) for group in groups for run, error, command in group.failures
    )
    return list(islice(runs, _MOST))
