"""One step of many robots, compiled: drive until the next scan, take it, and update the progress on the route."""

from math import atan2, cos, hypot, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.batch.grid import crop, mark_ranges
from sim.batch.lidar import Turn, take_scan
from sim.batch.robots import BatchObservation, Robots, Scratch, make_scratch
from sim.batch.worlds import Timing, Worlds
from sim.dead_reckoning import reported_pose, take_mean_twist
from sim.firmware import command
from sim.plan.advance import advance, walk
from sim.plan.base import put_down
from sim.random_stream import GOLDEN, mixed, stream_of
from slam.compiled import compiled, compiled_on_views, wrapped
from slam.pose import FloatArray


@compiled
def begin_streams(base: NDArray[Any], seeds: NDArray[np.uint64], chosen: NDArray[np.bool_]) -> None:
    """Start the random streams of the chosen robots."""
    for i in range(len(base)):
        if chosen[i]:
            base[i].stream = stream_of(seeds[i])


@compiled
def step_robots(
    first: int, stop: int, begins: NDArray[np.bool_], continues: NDArray[np.bool_], commands: FloatArray,
    worlds: Worlds, timing: Timing, polar: bool, cell: float, robots: Robots, seen: BatchObservation,
) -> None:  # fmt: skip
    """Let the robots ``first`` to ``stop`` begin an episode, or continue theirs until the next scan.

    ``commands`` (N, 2) are v and omega. No robot depends on another one here.
    """
    scratch = make_scratch(worlds, timing)
    for i in range(first, stop):
        if begins[i] or continues[i]:
            _step(i, begins[i], commands[i, 0], commands[i, 1], worlds, timing, polar, cell, robots, seen, scratch)


@compiled_on_views
def _step(
    i: int, begins: bool, v: float, omega: float,
    worlds: Worlds, timing: Timing, polar: bool, cell: float, robots: Robots, seen: BatchObservation, scratch: Scratch,
) -> None:  # fmt: skip
    if begins:
        _begin(i, worlds, robots)
    else:
        command(robots.base[i], worlds.models[robots.world[i]], v, omega)
    turn = _observe(i, worlds, timing, robots, seen, scratch)
    _follow_route(i, worlds, robots, seen, begins, polar)
    if robots.cells.shape[1]:
        _map(i, worlds, timing, cell, robots, seen, begins, turn, scratch)


@compiled_on_views
def _begin(i: int, worlds: Worlds, robots: Robots) -> None:
    """Put a robot at the start of a world that its random numbers choose."""
    base = robots.base[i]
    stream = base.stream + GOLDEN
    w = int(mixed(stream) % np.uint64(len(worlds.starts)))
    robots.world[i] = w
    put_down(base, worlds.starts[w, 0], worlds.starts[w, 1], worlds.starts[w, 2], stream)
    for p in range(robots.walked.shape[1]):
        robots.walked[i, p, 0], robots.walked[i, p, 1] = worlds.crowd.starts[w, p], 0.0
    walk(base, worlds.crowd, w, 0.0, robots.walked[i], robots.people[i], robots.legs[i])
    robots.waypoint[i] = robots.turns[i] = 0
    for row in range(robots.cells.shape[1]):
        for column in range(robots.cells.shape[2]):
            robots.cells[i, row, column] = 0


@compiled_on_views
def _observe(i: int, worlds: Worlds, timing: Timing, robots: Robots, seen: BatchObservation, scratch: Scratch) -> Turn:
    """Let the time of one scan pass, and take the scan as ``SimRobot.observe`` does.

    Its ranges are in the scratch arrays.
    """
    w, base = robots.world[i], robots.base[i]
    model = worlds.models[w]
    seen.applied[i, 0], seen.applied[i, 1] = base.target_v, base.target_omega
    base.collided = base.bumpers = 0
    _pass(i, timing.controls_before, worlds, robots, scratch)
    twist = take_mean_twist(base, model, timing.controls_before * timing.period)
    seen.pose[i, 0], seen.pose[i, 1], seen.pose[i, 2] = base.x, base.y, base.theta
    reported = reported_pose(base, model)
    _pass(i, timing.controls_in_sweep, worlds, robots, scratch)
    if timing.controls_in_sweep:
        twist = take_mean_twist(base, model, timing.controls_in_sweep * timing.period)
    if len(seen.odometry):
        seen.odometry[i, 0], seen.odometry[i, 1], seen.odometry[i, 2] = reported
        seen.odometry[i, 3], seen.odometry[i, 4] = twist
    seen.collided[i], seen.stalled[i] = base.collided != 0, base.stalled != 0
    turn = take_scan(i, worlds, timing, robots, seen, scratch)
    robots.turns[i] += 1
    seen.late[i] = robots.turns[i] >= worlds.last_turn[w]
    return turn


@compiled_on_views
def _pass(i: int, controls: int, worlds: Worlds, robots: Robots, scratch: Scratch) -> None:
    """Run a number of control steps; the scratch arrays get the poses of base and legs before and after each."""
    w = robots.world[i]
    advance(
        robots.base[i], worlds.models[w], True, worlds.obstacles, worlds.crowd, w, robots.walked[i], robots.people[i],
        robots.legs[i], scratch.path[: controls + 1], scratch.legs[: controls + 1],
    )  # fmt: skip


@compiled_on_views
def _follow_route(i: int, worlds: Worlds, robots: Robots, seen: BatchObservation, begins: bool, polar: bool) -> None:
    """Pass the way-points that are reached, as ``RouteProgress.advance`` does, and locate the next one."""
    w, k = robots.world[i], robots.waypoint[i]
    x, y = seen.pose[i, 0], seen.pose[i, 1]
    left = 0.0
    while k < worlds.waypoint_counts[w]:
        distance = hypot(worlds.waypoints[w, k, 0] - x, worlds.waypoints[w, k, 1] - y)
        left = distance + worlds.after[w, k]
        if distance > worlds.arrival[w]:
            break
        k += 1
        left = 0.0
    seen.gained[i, 0] = 0.0 if begins else robots.left[i] - left
    robots.left[i], robots.waypoint[i] = left, k
    seen.arrived[i] = k == worlds.waypoint_counts[w] and k > 0
    if len(seen.goal):
        _see_goal(i, w, k, worlds, seen, polar)


@compiled_on_views
def _see_goal(i: int, w: int, k: int, worlds: Worlds, seen: BatchObservation, polar: bool) -> None:
    if k == worlds.waypoint_counts[w]:
        seen.goal[i, 0] = seen.goal[i, 1] = 0.0
        return
    x, y, theta = seen.pose[i, 0], seen.pose[i, 1], seen.pose[i, 2]
    dx, dy = worlds.waypoints[w, k, 0] - x, worlds.waypoints[w, k, 1] - y
    if polar:
        seen.goal[i, 0], seen.goal[i, 1] = hypot(dx, dy), wrapped(atan2(dy, dx) - theta)
    else:
        c, s = cos(theta), sin(theta)
        seen.goal[i, 0], seen.goal[i, 1] = c * dx + s * dy, c * dy - s * dx


@compiled_on_views
def _map(
    i: int, worlds: Worlds, timing: Timing, cell: float, robots: Robots, seen: BatchObservation, begins: bool,
    turn: Turn, scratch: Scratch,
) -> None:  # fmt: skip
    """Mark the cells that the scan sees in the robot's grid, and cut out the square around the robot."""
    w = robots.world[i]
    x, y, theta = seen.pose[i, 0], seen.pose[i, 1], seen.pose[i, 2]
    mx, my = worlds.mounts[w, 0], worlds.mounts[w, 1]
    c, s, cells = cos(theta), sin(theta), robots.cells[i, : worlds.grids[w, 0], : worlds.grids[w, 1]]
    laser_x = (x + c * mx - s * my - worlds.low[w, 0]) / cell
    laser_y = (y + s * mx + c * my - worlds.low[w, 1]) / cell
    count = len(turn.bearings)
    ends, echoes = scratch.rays[: 2 * count].reshape((2, count)), scratch.echoes[:count]
    found = mark_ranges(
        cells, laser_x, laser_y, c, s, turn.beams, scratch.ranges[:count], timing.range_max, cell,
        timing.whole_turn, ends, echoes,
    )  # fmt: skip
    seen.gained[i, 1] = 0.0 if begins else found
    if len(seen.map):
        crop(cells, (x - worlds.low[w, 0]) / cell, (y - worlds.low[w, 1]) / cell, c, s, seen.map[i, 0])
