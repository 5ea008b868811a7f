"""The people of a scenario in the simulated world."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from sim.gait import walk_all
from sim.world import OUT_OF_REACH, World
from slam.pose import FloatArray, path_lengths
from slam.scenario.world_plan import Person

LEG_HEIGHT: Final = 0.85
"""Metres; the lidar takes a person's legs to be this high, and sees nothing of a person above."""
NEAR: Final = 1.5
"""Within this distance of the robot, metres, the legs of a person are in the physics, where they can be run into."""


class People:
    """Walk when told how much time passed; their legs are upright cylinders that nothing can push."""

    def __init__(self, world: World, persons: Sequence[Person]) -> None:
        self._world = world
        self._persons = persons
        ways = [_closed_way(person) for person in persons]
        self._node_counts = np.array([len(way) for way in ways], np.int64)
        self._nodes = np.zeros((len(ways), max(map(len, ways), default=0), 2))
        self._distances = np.zeros(self._nodes.shape[:2])
        for p, way in enumerate(ways):
            self._nodes[p, : len(way)] = way
            self._distances[p, : len(way)] = path_lengths(way)
        self._habits = np.array([[p.speed, p.pause, p.keep, p.stance, p.stride] for p in persons]).reshape(-1, 5)
        self.leg_radii = np.repeat([p.leg_radius for p in persons], 2).astype(np.float64)
        self._pillars = [world.add_pillar(radius, LEG_HEIGHT) for radius in self.leg_radii]
        self.restart()

    def __len__(self) -> int:
        """Number of people."""
        return len(self._persons)

    def restart(self) -> None:
        """Put each of them back at their start."""
        self._state = np.array([[p.start, 0.0] for p in self._persons]).reshape(-1, 2)
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
        """Middles of all legs now, (2 P, 2): left and right of the first person, then of the next."""
        return self._legs.reshape(-1, 2).copy()

    def _walk(self, robot: tuple[float, float], seconds: float) -> None:
        walk_all(
            self._nodes, self._distances, self._node_counts, self._habits, self._state, robot, seconds,
            self.positions, self._legs,
        )  # fmt: skip

    def _place_legs(self, robot: tuple[float, float]) -> None:
        """Put the legs of people near the robot into the physics, and take the others out."""
        for p, (x, y) in enumerate(self.positions.tolist()):
            near = (x - robot[0]) ** 2 + (y - robot[1]) ** 2 < NEAR**2
            if near or self._in_physics[p]:
                for pillar, leg in zip(self._pillars[2 * p : 2 * p + 2], self._legs[p].tolist(), strict=True):
                    self._world.move(pillar, *((*leg, LEG_HEIGHT / 2.0) if near else OUT_OF_REACH))
                self._in_physics[p] = near


def _closed_way(person: Person) -> FloatArray:
    """Way-points (K, 2) of a walk that ends where it began; points in a row that are the same count once."""
    out = list(person.waypoints)
    back = [out[0]] if person.closed else out[-2::-1]
    points = [*out, *back] if len(out) > 1 else out
    kept = [point for k, point in enumerate(points) if k == 0 or point != points[k - 1]]
    return np.array(kept, np.float64)
