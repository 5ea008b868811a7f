"""The scenario that a command was given, with a warning about whatever is strange in it."""

from __future__ import annotations

import sys

from slam.scenario.schema import Scenario
from slam.scenario.template import ScenarioTemplate


def draw_with_warnings(template: ScenarioTemplate) -> Scenario:
    """The scenario of the template's own seed; strange values are told on standard error, a line each."""
    scenario = template.draw()
    for warning in template.warnings(scenario):
        print(f"hopslam: warning: {warning}", file=sys.stderr)
    return scenario
