"""Simulated scans with known walls, for the benchmark of line extractors."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from slam.bench.floor_plans import FAMILIES, cast_beams
from slam.lidars import URG04LX
from slam.lines.segments import IntArray
from slam.pose import FloatArray, Pose2D, unit_vectors
from slam.scan import LaserScan

TUNING_SEEDS: Final = range(60)
"""Seeds of the scenes on which the extractors were tuned."""
HELD_OUT_SEEDS: Final = range(1000, 1060)
"""Seeds of the scenes on which they are compared."""
WARM_UP_SEEDS: Final = range(2000, 2060)
"""Seeds of the rooms in which a sensor learns its noise."""
NOISE_LEVELS: Final = {"spec/19": 1 / 19, "spec/3": 1 / 3, "spec": 1.0}
"""Standard deviation of the range noise as a share of the maker's bound: 25 mm below 1 m, 2.5 % of the range beyond."""
REACH: Final = 4.0
DROPOUT: Final = 0.005


@dataclass(frozen=True, slots=True, eq=False)
class VisibleWalls:
    """Walls that a scan saw: W maximal runs of consecutive beams on one wall; lost beams belong to their run."""

    first: IntArray  # (W,) first beam of the run
    last: IntArray  # (W,)
    start: FloatArray  # (W, 2) where the first beam hits the wall, sensor frame, metres
    end: FloatArray  # (W, 2) the same of the last beam

    @property
    def lengths(self) -> FloatArray:
        """Metres from start to end, shape (W,)."""
        return np.asarray(np.hypot(*(self.end - self.start).T))

    @property
    def required(self) -> NDArray[np.bool_]:
        """Mask of the walls that an extractor must find: at least 8 beams and 0.15 m; others are optional."""
        return (self.last - self.first + 1 >= 8) & (self.lengths >= 0.15)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Simulated scan, and the walls that it saw."""

    family: str
    seed: int
    noise_level: str
    scan: LaserScan
    walls: VisibleWalls


def make_scene(family: str, seed: int, noise_level: str) -> Scene:
    """Make the scene of this family and seed, see FAMILIES; the noise level, see NOISE_LEVELS, changes only noise."""
    number = list(FAMILIES).index(family)
    plan_random, noise_random = (np.random.default_rng([number, seed, stream]) for stream in range(2))
    walls = FAMILIES[family](plan_random)
    heading = Pose2D(theta=plan_random.uniform(-np.pi, np.pi))
    walls = heading.transform(walls.reshape(-1, 2)).reshape(-1, 2, 2)
    distance, wall = cast_beams(walls, Pose2D(), URG04LX.lidar.angles)
    seen = distance <= REACH
    distance, wall = np.where(seen, distance, np.inf), np.where(seen, wall, -1)
    ranges = _measure(distance, NOISE_LEVELS[noise_level], noise_random)
    lidar = URG04LX.lidar
    scan = LaserScan(0.0, lidar.angle_min, lidar.angle_increment, lidar.range_min, lidar.range_max, ranges)
    return Scene(family, seed, noise_level, scan, _visible_walls(distance, wall))


def scenes(seeds: range, noise_level: str) -> Iterator[Scene]:
    """Make the scenes of all families."""
    return (make_scene(family, seed, noise_level) for family in FAMILIES for seed in seeds)


def warm_up_scans(noise_level: str) -> Iterator[LaserScan]:
    """Yield scans with this noise, of each family in turn, in rooms that are not scored."""
    return (make_scene(family, seed, noise_level).scan for seed in WARM_UP_SEEDS for family in FAMILIES)


def _measure(distance: FloatArray, noise: float, random: np.random.Generator) -> FloatArray:
    """Turn true ranges into reported ranges."""
    sigma = noise * np.where(np.isfinite(distance), URG04LX.accuracy(distance), 0.0)
    ranges = distance + sigma * random.standard_normal(len(distance))
    ranges = np.round(ranges / URG04LX.resolution) * URG04LX.resolution
    ranges[random.random(len(distance)) < DROPOUT] = np.inf
    return np.asarray(ranges)


def _visible_walls(distance: FloatArray, wall: IntArray) -> VisibleWalls:
    change = np.flatnonzero(np.diff(wall)) + 1
    first, last = np.concatenate([[0], change]), np.concatenate([change, [len(wall)]]) - 1
    seen = wall[first] >= 0
    first, last = first[seen], last[seen]
    angles = URG04LX.lidar.angles
    start, end = (distance[at, None] * unit_vectors(angles[at]) for at in (first, last))
    return VisibleWalls(first, last, start, end)
