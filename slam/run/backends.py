"""The robots that a run can drive, by name, imported when they are used."""

import re
from typing import Any, Final, cast

from slam.errors import ScenarioError, did_you_mean
from slam.named_code import PLACE, call, find_code, import_by_name
from slam.own_checks import expect_parts
from slam.robot import Restartable, Robot
from slam.run.own_robot import OwnRobot, RestartableOwnRobot

BACKENDS: Final = {
    "sim": "sim.robot:SimRobot",
    "replay": "slam.run.replay_robot:ReplayRobot",
    "hardware": "hardware.robot:HardwareRobot",
    "ros": "slam.run.ros_robot.robot:TopicRobot",
}
"""Back ends by name; slam does not import sim and hardware."""

PLANTS: Final = {"sim": "sim.plant:SimPlant", "plan": "sim.plant:plan_plant"}
"""Functions from a scenario to the plant that moves the emulated devices."""
PLANT_PARTS: Final = (
    "T_map_base", "elapsed", "odometry", "travel", "stalled", "advance", "ranges", "bumpers", "sonar",
)  # fmt: skip
"""Attributes of a plant: see hardware/emulator/plant.py."""


def make_plant(name: str, *args: Any) -> Any:
    """Make the plant with this name; ScenarioError lists the known ones."""
    place = _place(name, PLANTS, "plant")
    if name in PLANTS:
        return import_by_name(place)(*args)
    plant = call(place, find_code(place, (place,)), *args)
    expect_parts(place, plant, PLANT_PARTS, "plant")
    return plant


def make_robot(backend: str, *args: Any, **options: Any) -> Robot:
    """Make a robot of the named back end, or of one named ``module:Class``, with the arguments of its class.

    ScenarioError lists the known names.
    """
    robot = _robot_code(backend)
    if backend in BACKENDS:
        return cast(Robot, robot(*args, **options))
    own = RestartableOwnRobot if _can_restart(robot) else OwnRobot
    return own(backend, *args, **options)


def is_restartable(backend: str) -> bool:
    """Return True if robots of this back end can be reset to their start."""
    return _can_restart(_robot_code(backend))


def _robot_code(backend: str) -> Any:
    """Return the class or function that makes the robots of the named back end."""
    place = _place(backend, BACKENDS, "robot back end")
    return import_by_name(place) if backend in BACKENDS else find_code(place, (place,))


def _can_restart(code: Any) -> bool:
    return isinstance(code, type) and issubclass(code, Restartable)


def _place(name: str, table: dict[str, str], kind: str) -> str:
    if name in table or re.fullmatch(PLACE, name):
        return table.get(name, name)
    hint = did_you_mean(name, table, otherwise=f"choose one of {', '.join(table)}, or give module:name")
    raise ScenarioError(f"no {kind} named {name!r}; {hint}")
