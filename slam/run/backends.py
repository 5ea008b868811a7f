"""The robots that a run can drive, by name, imported when they are used."""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module
from typing import Any, Final, cast

from slam.errors import ScenarioError
from slam.robot import Robot

BACKENDS: Final = {
    "sim": "sim.robot:SimRobot",
    "replay": "slam.run.logs.replay:ReplayRobot",
    "hardware": "hardware.robot:HardwareRobot",
}


def make_robot(backend: str, *args: Any, **options: Any) -> Robot:
    """A robot of the named back end, made from what its class takes; ScenarioError lists the known names."""
    try:
        module, _, name = BACKENDS[backend].partition(":")
    except KeyError:
        close = get_close_matches(backend, BACKENDS, n=1)
        hint = f"did you mean {close[0]}?" if close else f"choose one of {', '.join(BACKENDS)}"
        raise ScenarioError(f"no robot back end named {backend!r}; {hint}") from None
    return cast(Robot, getattr(import_module(module), name)(*args, **options))
