"""The lidars of a batch, compiled: the beams of a turn, their ranges, and the robot's view of them."""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from sim.batch.noise import disturb
from sim.batch.robots import BatchObservation, Robots, Scratch
from sim.batch.worlds import Timing, Worlds
from sim.random_stream import fill_uniform
from sim.rays import fire_beams
from sim.z_buffer import stop_at_legs, stop_at_walls
from slam.compiled import compiled_on_views
from slam.pose import FloatArray


class Turn(NamedTuple):
    """One turn of a lidar."""

    bearings: FloatArray
    """Bearings of the beams (B,), base frame."""
    beams: FloatArray
    """Unit vectors of the beams (2, B)."""
    begin: float
    """Bearing of the first beam, minus the nominal one (``angle_min`` of the lidar), radians."""
    increment: float
    """Seconds from beam to beam."""


@compiled_on_views
def take_scan(i: int, worlds: Worlds, timing: Timing, robots: Robots, seen: BatchObservation, scratch: Scratch) -> Turn:
    """Simulate one revolution into the scratch arrays; write ``seen.scan`` at the lidar's nominal bearings."""
    base, w = robots.base[i], robots.world[i]
    turn = _next_turn(w, worlds, timing, base, scratch)
    count = len(turn.bearings)
    ranges = scratch.ranges[:count]
    _cast(w, worlds, timing, turn, ranges, scratch)
    time = robots.turns[i] * timing.scan_time + timing.controls_before * timing.period
    disturb(ranges, worlds.sensors[w], timing, time, base, scratch.numbers[: 3 * count].reshape((3, count)))
    if len(seen.ranges):
        for j in range(count):
            seen.ranges[i, j] = ranges[j]
        seen.turns[i, 0], seen.turns[i, 1] = count, turn.begin
    if timing.beams_vary:
        step = turn.bearings[1] - turn.bearings[0]
        for j in range(seen.scan.shape[1]):
            nearest = int(np.rint((j * timing.angle_increment - turn.begin) / step)) % count
            seen.scan[i, j] = _shown(ranges[nearest], timing.range_max)
    else:
        for j in range(count):
            seen.scan[i, j] = _shown(ranges[j], timing.range_max)
    return turn


@compiled_on_views
def _shown(reading: float, range_max: float) -> float:
    """Convert a range for the view: nan and inf become range_max, a too close one 0."""
    near = 0.0 if reading < 0.0 else reading
    return near if near < np.inf else range_max


@compiled_on_views
def _next_turn(w: int, worlds: Worlds, timing: Timing, base: Any, scratch: Scratch) -> Turn:
    """Draw the beams of the next turn, as ``SimulatedLidar._turn`` does."""
    if not timing.beams_vary:
        return Turn(worlds.bearings[w], worlds.beams[w], 0.0, worlds.sensors[w].increment)
    nominal, vary, drawn = worlds.bearings.shape[1], timing.beams_vary, scratch.numbers[:2]
    base.stream = fill_uniform(base.stream, drawn)
    count = nominal - vary + int(drawn[0] * (2 * vary + 1))
    share = nominal / count
    step = timing.angle_increment * share
    begin, first = step * drawn[1], worlds.bearings[w, 0] + step * drawn[1]
    bearings, beams = scratch.bearings[:count], scratch.beams[: 2 * count].reshape((2, count))
    c, s, x, y = cos(step), sin(step), cos(first), sin(first)
    for j in range(count):
        bearings[j] = first + j * step
        beams[0, j], beams[1, j] = x, y
        x, y = c * x - s * y, s * x + c * y
    return Turn(bearings, beams, begin, worlds.sensors[w].increment * share)


@compiled_on_views
def _cast(w: int, worlds: Worlds, timing: Timing, turn: Turn, ranges: FloatArray, scratch: Scratch) -> None:
    """Find the distance along each beam; inf if nothing is in range."""
    rays = scratch.rays[: 5 * len(ranges)].reshape((5, len(ranges)))
    rows = timing.controls_in_sweep + 1
    fire_beams(scratch.path[:rows], timing.period, worlds.mounts[w], turn.bearings, turn.beams, turn.increment, rays)
    for j in range(len(ranges)):
        ranges[j] = np.inf
    stop_at_walls(rays, ranges, worlds.walls, w)
    radii = worlds.crowd.leg_radii[w]
    if len(radii) and worlds.sensors[w].sees_legs:
        stop_at_legs(rays, ranges, scratch.legs[:rows], radii, turn.increment / timing.period)
    for j in range(len(ranges)):
        ranges[j] = ranges[j] if ranges[j] <= timing.reach else np.inf
