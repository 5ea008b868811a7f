"""Drives of a blocked base: against people, walls and sills for several seconds."""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Any, Final, Literal

import numpy as np

from sim.robot import SimRobot
from slam.odometry import Twist2D
from slam.pose import FloatArray, wrap_angles
from slam.scenario.schema import Scenario

FORWARD: Final = Twist2D(0.3)
AT_REST: Final = 2e-3
"""A base that moves less than this from scan to scan is at rest: metres, and radians times 0.2 m."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Record of one command that was held: a row for each scan."""

    seconds: FloatArray
    truth: FloatArray
    """(S, 3): x, y, theta of ``T_map_base``; metres, radians."""
    odometry: FloatArray
    """(S, 3): x, y, theta of ``T_odom_base``; metres, radians."""
    stalled: FloatArray
    """(S,): 1 where the motors were cut."""

    @property
    def stood_at(self) -> float:
        """Seconds until the base came to rest for good."""
        steps = np.diff(self.truth, axis=0)
        moved = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) + 0.2 * np.abs(wrap_angles(steps[:, 2])) > AT_REST)
        return float(self.seconds[moved[-1] + 1 if len(moved) else 0])

    @property
    def stalled_at(self) -> float:
        """Seconds until the first scan that reports a stall; nan without one."""
        return float(self.seconds[np.argmax(self.stalled)]) if self.stalled.any() else float("nan")

    @property
    def odometry_after_stall(self) -> tuple[float, float]:
        """Largest distance and turn of the odometry since the first stall: metres, radians; nan without a stall."""
        if not self.stalled.any():
            return float("nan"), float("nan")
        after = self.odometry[np.argmax(self.stalled) :]
        away = after - after[0]
        return float(np.hypot(away[:, 0], away[:, 1]).max()), float(np.abs(np.unwrap(away[:, 2])).max())


def scene(world: dict[str, Any], **parts: Any) -> Scenario:
    """Make a scenario with this world, odometry without rounding, and a lidar with few beams."""
    robot = {"odometry": {"firmware_units": False}} | parts.pop("robot", {})
    lidar = {"model": "table1", "noise": "none"}
    return Scenario.model_validate(
        {"name": "blocked", "world": world, "lidar": lidar, "robot": robot, "duration": 1e6} | parts
    )


def wall(angle: float, at: float = 1.0, length: float = 4.0) -> dict[str, Any]:
    """Make a world with one wall through (``at``, 0), whose normal is turned ``angle`` radians from the x axis."""
    dx, dy = -sin(angle) * length / 2.0, cos(angle) * length / 2.0
    return {"walls": [{"points": [[at - dx, -dy], [at + dx, dy]]}]}


def sill(height: float, at: float = 0.6, **box: Any) -> dict[str, Any]:
    """Make a world with one sill across the x axis, ``height`` metres high."""
    return {"boxes": [{"center": [at, 0.0], "size": [0.1, 4.0, height]} | box]}


def drive(scenario: Scenario, command: Twist2D = FORWARD, seconds: float = 13.0, seed: int = 0) -> Drive:
    """Hold the command for ``seconds``, and record each scan."""
    rows = []
    with SimRobot(scenario, seed) as robot:
        for _ in range(round(10.0 * seconds)):
            robot.drive(command)
            observation = robot.observe()
            assert observation is not None
            assert observation.T_map_base is not None
            T_map_base, T_odom_base = observation.T_map_base, observation.odometry.T_odom_base
            rows.append((*T_map_base.as_array(), *T_odom_base.as_array(), observation.stalled))
    table = np.array(rows, np.float64)
    stamps = np.linspace(0.1, 0.1 * len(table), len(table))
    return Drive(stamps, table[:, :3], table[:, 3:6], table[:, 6])


def sill_outcome(
    scenario: Scenario, command: Twist2D = FORWARD, seconds: float = 5.0
) -> Literal["over", "stopped", "hung"]:
    """Drive at a sill, and return ``over``, ``stopped`` or ``hung``.

    ``over``: the robot keeps its speed; ``stopped``: it stops and reports a stall; ``hung``: anything else.
    """
    driven = drive(scenario, command, seconds)
    speed = 10.0 * np.hypot(*(driven.truth[-1, :2] - driven.truth[-2, :2]))
    if not driven.stalled.any() and abs(speed - abs(command.linear)) < 0.02:
        return "over"
    return "stopped" if driven.stalled[-1] and driven.odometry_after_stall[0] < 0.02 else "hung"


CASES: Final[dict[str, dict[str, Any]]] = {
    "a person": {"world": wall(0.0, at=9.0), "people": [{"waypoints": [[1.2, 0.0]]}]},
    "a person at a corner of the robot": {"world": wall(0.0, at=9.0), "people": [{"waypoints": [[1.2, 0.2]]}]},
    "two people": {"world": wall(0.0, at=9.0), "people": [{"waypoints": [[1.2, y]]} for y in (-0.15, 0.15)]},
    **{f"a wall at {angle} degrees": {"world": wall(radians(angle))} for angle in (0, 10, 30, 45, 60)},
    "a corner of the room": {"world": {"walls": [{"points": [[1.0, -2.0], [1.0, 0.3], [-2.0, 0.3]]}]}},
}
"""Obstacles for a robot that starts at the origin and drives along x; a wall at 0 degrees is met head on."""
