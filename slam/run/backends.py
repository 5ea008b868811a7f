"""The robots that a run can drive, by name, imported when they are used."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, Final, cast

from slam.errors import ScenarioError
from slam.late import late
from slam.robot import Robot

BACKENDS: Final = {
    "sim": "sim.robot:SimRobot",
    "replay": "slam.run.logs.replay:ReplayRobot",
    "hardware": "hardware.robot:HardwareRobot",
}
"""slam knows of sim and hardware by name only."""

PLANTS: Final = {"sim": "sim.plant:SimPlant", "plan": "hardware.emulator.kinematic_plant:scenario_plant"}
"""What moves the emulated devices: a function of the scenario."""


def make_plant(name: str, *args: Any) -> Any:
    """The plant of this name; ScenarioError lists the known ones."""
    return late(_place(name, PLANTS, "plant"))(*args)


def make_robot(backend: str, *args: Any, **options: Any) -> Robot:
    """A robot of the named back end, or of one named ``module:Class``, made from what its class takes; ScenarioError
    lists the known names."""
    return robot_class(backend)(*args, **options)


def robot_class(backend: str) -> Callable[..., Robot]:
    """What makes the robots of the named back end."""
    return cast(Callable[..., Robot], late(_place(backend, BACKENDS, "robot back end")))


def _place(name: str, table: dict[str, str], kind: str) -> str:
    if name in table or ":" in name:
        return table.get(name, name)
    close = get_close_matches(name, table, n=1)
    hint = f"did you mean {close[0]}?" if close else f"choose one of {', '.join(table)}, or give module:name"
    raise ScenarioError(f"no {kind} named {name!r}; {hint}")
