"""The people of a scenario in the simulated world."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from sim.crowd import crowd_of
from sim.gait import LEG_HEIGHT, walk_all
from sim.world import OUT_OF_REACH, World
from slam.pose import FloatArray
from slam.scenario.world_plan import Person

NEAR: Final = 1.5
"""Distance to the robot, metres, within which the legs of a person are in the physics and can be hit."""


class People:
    """People who walk along their paths; their legs are upright cylinders that nothing can push."""

    def __init__(self, world: World, persons: Sequence[Person]) -> None:
        self._world = world
        self._persons = persons
        crowd = crowd_of([persons])
        self._ways = crowd.nodes[0], crowd.distances[0], crowd.node_counts[0], crowd.habits[0]
        self._starts, self.leg_radii = crowd.starts[0], crowd.leg_radii[0]
        self._pillars = [world.add_pillar(radius, LEG_HEIGHT) for radius in self.leg_radii]
        self.restart()

    def __len__(self) -> int:
        """Number of people."""
        return len(self._persons)

    def restart(self) -> None:
        """Return all people to their start."""
        self._state = np.column_stack([self._starts, np.zeros(len(self._persons))])
        self.positions = np.zeros((len(self._persons), 2))
        self._legs = np.zeros((len(self._persons), 2, 2))
        self._in_physics = [False] * len(self._persons)
        for pillar in self._pillars:
            self._world.move(pillar, *OUT_OF_REACH)
        self._walk((0.0, 0.0), 0.0)

    def step(self, robot: tuple[float, float], seconds: float) -> None:
        """Let ``seconds`` pass, with the robot at x and y, metres."""
        self._walk(robot, seconds)
        self._place_legs(robot)

    @property
    def legs(self) -> FloatArray:
        """Middles of all legs, (2 P, 2): left and right of the first person, then of the next."""
        return self._legs.reshape(-1, 2).copy()

    def _walk(self, robot: tuple[float, float], seconds: float) -> None:
        walk_all(*self._ways, self._state, robot, seconds, self.positions, self._legs)

    def _place_legs(self, robot: tuple[float, float]) -> None:
        """Put the legs of people near the robot into the physics, and take the others out."""
        for p, (x, y) in enumerate(self.positions.tolist()):
            near = (x - robot[0]) ** 2 + (y - robot[1]) ** 2 < NEAR**2
            if near or self._in_physics[p]:
                for pillar, leg in zip(self._pillars[2 * p : 2 * p + 2], self._legs[p].tolist(), strict=True):
                    self._world.move(pillar, *((*leg, LEG_HEIGHT / 2.0) if near else OUT_OF_REACH))
                self._in_physics[p] = near
