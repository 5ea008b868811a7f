"""The simulated robot as a gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sim.robot import SimRobot
from slam.odometry import Twist2D
from slam.run.robot_env import RobotEnv
from slam.run.scenario.file import load_scenario
from slam.run.scenario.schema import Scenario


class P3DXEnv(RobotEnv):
    """A Pioneer P3-DX with a planar lidar in the world of a scenario.

    ## Description
    A differential-drive robot drives through a PyBullet world. One step lasts one turn of the lidar, 0.1 s.

    ## Action Space
    ``Box(-1, 1, (2,), float32)``: forward velocity in m/s and turning velocity in rad/s, counter-clockwise. The base
    follows within the scenario's limits of speed and acceleration; a faster command is obeyed up to those limits.

    ## Observation Space
    | key | shape | content |
    |---|---|---|
    | ``scan`` | (beams,) | ranges in metres; ``range_max`` where no echo came back, 0 where something is too close |
    | ``odometry`` | (5,) | x, y (m), theta (rad), v (m/s), omega (rad/s) as the wheels report, from the start pose |

    ``info["observation"]`` is the whole ``slam.robot.Observation``, with ``T_map_base``, the true pose; after a step
    ``info["applied"]`` is the velocity that was driven.

    ## Rewards
    None: 0 at every step.

    ## Starting State
    The scenario's start pose, at rest.

    ## Episode End
    Terminated when the robot touches anything but the floor; truncated when the scenario's ``duration`` is over.

    ## Arguments
    ``scenario``: the name of a shipped scenario, a path to a YAML file, or a ``Scenario``. ``settings``: ``key=value``
    strings on top of it.

    ## Version History
    v0: the first.
    """

    def __init__(self, scenario: str | Path | Scenario = "corridor", settings: Sequence[str] = ()) -> None:
        self.scenario = scenario if isinstance(scenario, Scenario) else load_scenario(scenario, settings)
        limits = self.scenario.robot.limits
        super().__init__(
            lambda seed: SimRobot(self.scenario, seed),
            self.scenario.lidar.description.lidar,
            Twist2D(limits.linear, limits.angular),
        )
