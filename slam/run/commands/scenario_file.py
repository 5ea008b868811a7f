"""The scenario that a command was given, with a warning about whatever is strange in it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from slam.run.scenario.file import load_template
from slam.run.scenario.schema import Scenario


def load_with_warnings(name: str, settings: Sequence[str] | None, seed: int | None) -> Scenario:
    """The scenario of this seed, or of its own; strange values are told on standard error, a line each."""
    by_seed = [] if seed is None else [f"seed={seed}"]
    template = load_template(name, [*(settings or []), *by_seed])
    scenario = template.draw()
    for caution in template.cautions(scenario):
        print(f"hopslam: warning: {caution}", file=sys.stderr)
    return scenario
