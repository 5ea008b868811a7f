"""The manual of an environment, as Markdown: what its class says of itself, and what it is as built."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import getdoc
from typing import Any

import gymnasium

from slam.env.ids import register_ids


def manual(env_id: str) -> str:
    """Of the registered environment of this whole id, with its default arguments."""
    register_ids()
    with gymnasium.make(env_id) as made:
        docstring = getdoc(type(made.unwrapped))
        rows = "\n".join(f"| {name} | {value} |" for name, value in _as_built(made.unwrapped))
    return f"# {env_id}\n\n{docstring}\n\n## As built\n\n| | |\n|---|---|\n{rows}\n"


def _as_built(env: Any) -> Iterator[tuple[str, str]]:
    """The spaces and the clock of this one environment."""
    scenario = env.scenario
    clock, scan_time = scenario.clock, scenario.lidar.description.lidar.scan_time
    yield "action", f"`{env.action_space}`"
    for name, space in env.observation_space.spaces.items():
        yield f"observation {name}", f"`{' '.join(str(space).split())}`"
    yield (
        "time",
        f"a step is a scan, {scan_time:g} s: {clock.controls_per_scan} control steps "
        f"of {clock.steps_per_control} physics steps of 1/{clock.rate} s",
    )
    yield "scenario", f"{scenario.name}: {scenario.description}"
