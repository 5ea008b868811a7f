"""Quality of a map without ground truth: crisp walls, walls along the building's axes, and closed loops."""

from collections.abc import Sequence
from itertools import product
from typing import Final, NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

from slam.bench.log_runs import LogRun
from slam.bench.wall_faults import WallFaults, wall_faults
from slam.console.result_table import ResultTable
from slam.deskew import deskewed
from slam.files.logs import Log
from slam.pose import FloatArray, Pose2D

CELL: Final = 0.05
"""Side of the cells that are counted for the crispness, metres."""
LONG_WALL: Final = 2.0
"""Least length of a wall whose direction is used, metres."""
URG_BEAMS: Final = 600
"""Scans with more beams are those of a URG-04LX."""
CRISP_URG: Final = 70, 4.0
"""Crispness of a URG-04LX: beams left out at each end, and the range from which readings are left out, metres."""
CRISP_OTHERS: Final = 0, 15.0
"""The same for other sensors."""
LOOPS: Final = {"duke_loop5": (50, 73)}
"""Logs that return to their start, and the number of scans at the beginning and at the end that show the same place."""
LOOP_REACH: Final = 8.0
"""Longest range used of these scans, metres."""
LOOP_NEAR: Final = 0.075
"""Distance within which a point of the last scans agrees with the first ones, metres."""
LOOP_STEPS: Final = ((1.0, 0.10, np.radians(6.0), np.radians(1.0)), (0.10, 0.025, np.radians(1.0), np.radians(0.25)))
"""Half window and step of the search, metres and radians; the second search is about the best of the first."""


class LoopGap(NamedTuple):
    """Motion that aligns the last points of a loop with the first ones."""

    along: float
    """Shift in the direction of ``heading``, metres."""
    across: float
    """Shift to the left of ``heading``, metres."""
    turn: float
    """Rotation about the mean of the last points, radians."""
    agreement: float
    """Share of the last points near the first ones after the motion."""
    before: float
    """Share of the last points near the first ones before the motion."""


def shape_table(found: Sequence[tuple[str, LogRun]]) -> ResultTable:
    """Make the table of the maps' shapes, a row for each log."""
    columns = (
        "log", f"walls of\n{LONG_WALL:g} m", "off axes\nrms, deg", "most\ndeg", "all walls\nm", "lines\na metre",
        "radial\nm", "parallel\nm", "unseen\nm", "open along\nm", "across\nm", "heading\ndeg", "agree", "unmoved",
    )  # fmt: skip
    notes = (
        "Off axes: deviation of the walls' directions, modulo 90 deg, from their mean, weighted by length; it is "
        "larger in a building with walls at other angles. Radial: lines along most of the beams that saw them; "
        "parallel: lines within 0.3 m of a longer one that faces the same side; unseen: lines without an echo within "
        "0.1 m. Open: motion that aligns the last scans with the first, along and across the first heading. Agree, "
        "unmoved: share of their points, one per 5 cm cell, that fit after this motion, and without it."
    )
    rows = [(name, *_walls(run.walls), *_faults(faults_of(run)), *_loop(run)) for name, run in found]
    return ResultTable("Shapes", columns, rows, notes)


def faults_of(run: LogRun) -> WallFaults:
    """Measure the line map of a run against the echoes of all its scans, each at its pose as estimated then."""
    deskew = run.log.time_increment != 0.0
    echoes = [end_points(run.log, k, pose, 0, np.inf, deskew) for k, pose in enumerate(run.poses)]
    lasers = [(Pose2D(*pose.tolist()) @ run.log.T_base_laser).translation for pose in run.poses]
    origins = np.repeat(np.array(lasers), [len(points) for points in echoes], axis=0)
    return wall_faults(run.walls, np.concatenate(echoes), origins)


def crispness_beams(log: Log) -> tuple[int, float]:
    """Beams and ranges that the crispness of a log leaves out."""
    return CRISP_URG if log.lidar.beams > URG_BEAMS else CRISP_OTHERS


def crispness(log: Log, poses: FloatArray, cut: int, reach: float, deskew: bool) -> float:
    """Count occupied cells of 5 cm per 1000 points, with every scan drawn at its pose, deskewed or not.

    The first and last ``cut`` beams and ranges of ``reach`` metres and more are left out.
    """
    drawn = np.concatenate([end_points(log, k, poses[k], cut, reach, deskew) for k in range(len(log))])
    return 1000.0 * len(np.unique(drawn // CELL, axis=0)) / max(len(drawn), 1)


def end_points(log: Log, index: int, pose: FloatArray, cut: int, reach: float, deskew: bool) -> FloatArray:
    """Return the end points of the beams of one scan, (M, 2), metres in the frame of the poses of the base."""
    scan = log.scan(index)
    if deskew:
        scan = deskewed(scan, log.odometry(index).twist, log.T_base_laser)
    used = np.isfinite(scan.ranges) & (scan.ranges > 0.0) & (scan.ranges < reach)
    used[:cut] = used[len(used) - cut :] = False
    r, bearings = scan.ranges[used], scan.bearings[used]
    T_map_laser = Pose2D(*pose.tolist()) @ log.T_base_laser
    return T_map_laser.transform(np.column_stack([r * np.cos(bearings), r * np.sin(bearings)]))


def angles_off_main_axes(walls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the angle of each wall (M, 2, 2) from the main axes, modulo a right angle, and its length, (M,) each.

    Radians and metres.
    """
    vectors = walls[:, 1] - walls[:, 0]
    lengths, fourfold = np.hypot(*vectors.T), np.exp(4j * np.arctan2(vectors[:, 1], vectors[:, 0]))
    return np.angle(fourfold / np.sum(lengths * fourfold)) / 4.0, lengths


def rms_off_axes(walls: FloatArray) -> float:
    """Return the RMS angle of the long walls, of (M, 2, 2), from the main axes, radians.

    It is weighted by length; nan if no wall is long.
    """
    long = _long(walls)
    if not len(long):
        return float("nan")
    angles, lengths = angles_off_main_axes(long)
    return float(np.sqrt(np.average(angles**2, weights=lengths)))


def gap_of_loop(name: str, log: Log, poses: FloatArray) -> LoopGap | None:
    """Align the last scans of a log with the first ones, at poses (N, 3); None if it does not return to its start."""
    if name not in LOOPS:
        return None
    begin, end = LOOPS[name]
    count = len(poses)
    first, last = (_seen(log, poses, scans) for scans in (range(begin), range(count - end, count)))
    return loop_gap(first, last, float(poses[0, 2]))


def loop_gap(first: FloatArray, last: FloatArray, heading: float) -> LoopGap:
    """Fit the points ``last`` (M, 2) to ``first`` (N, 2), metres, along and across ``heading``, radians."""
    c, s = np.cos(heading), np.sin(heading)
    turned = np.array([[c, -s], [s, c]])  # from x, y to along, across, for rows
    first, last = _thinned(first @ turned), _thinned(last @ turned)
    near, corner = _picture(first)
    middle, best = last.mean(axis=0), np.zeros(3)
    for reach, step, reach_turn, step_turn in LOOP_STEPS:
        best = max(
            _around(best, reach, step, reach_turn, step_turn), key=lambda t: _share(near, corner, last, middle, t)
        )
    agreement, before = (_share(near, corner, last, middle, moved) for moved in (best, np.zeros(3)))
    return LoopGap(float(best[0]), float(best[1]), float(best[2]), agreement, before)


def _walls(walls: FloatArray) -> tuple[str, str, str]:
    long = _long(walls)
    if not len(long):
        return "0", "", ""
    angles, _ = angles_off_main_axes(long)
    return str(len(long)), f"{np.degrees(rms_off_axes(long)):.2f}", f"{np.degrees(np.abs(angles).max()):.1f}"


def _long(walls: FloatArray) -> FloatArray:
    return np.asarray(walls[np.hypot(*(walls[:, 1] - walls[:, 0]).T) >= LONG_WALL])


def _faults(found: WallFaults) -> tuple[str, ...]:
    metres = f"{found.radial:.1f}", f"{found.parallel:.1f}", f"{found.unseen:.1f}"
    return f"{found.length:.0f}", f"{found.lines_per_metre:.2f}", *metres


def _loop(run: LogRun) -> tuple[str, ...]:
    gap = gap_of_loop(run.name, run.log, run.poses)
    if gap is None:
        return ("",) * 5
    return (
        f"{gap.along:.2f}", f"{gap.across:.2f}", f"{np.degrees(gap.turn):.2f}", f"{gap.agreement:.2f}",
        f"{gap.before:.2f}",
    )  # fmt: skip


def _seen(log: Log, poses: FloatArray, scans: Sequence[int]) -> FloatArray:
    deskew = log.time_increment != 0.0
    return np.concatenate([end_points(log, k, poses[k], 0, LOOP_REACH, deskew) for k in scans])


def _thinned(points: FloatArray) -> FloatArray:
    return (np.unique(np.floor(points / CELL), axis=0) + 0.5) * CELL


def _picture(points: FloatArray) -> tuple[np.ndarray, FloatArray]:
    """Return a mask of the cells of half CELL near a point, and the lower corner of the first of them."""
    margin = 4
    corner = points.min(axis=0) - 0.5 * CELL * margin
    index = np.floor((points - corner) / (0.5 * CELL)).astype(int)
    empty = np.ones(index.max(axis=0) + margin + 1, np.bool_)
    empty[tuple(index.T)] = False
    return distance_transform_edt(empty) * 0.5 * CELL <= LOOP_NEAR, corner


def _around(best: FloatArray, reach: float, step: float, reach_turn: float, step_turn: float) -> list[FloatArray]:
    """Return the steps of a window, nearest first, so that ties go to the smallest motion."""
    places = np.arange(-round(reach / step), round(reach / step) + 1) * step
    turns = np.arange(-round(reach_turn / step_turn), round(reach_turn / step_turn) + 1) * step_turn
    window = np.array(list(product(places, places, turns)))
    return list(best + window[np.argsort(np.abs(window) @ np.ones(3), kind="stable")])


def _share(near: np.ndarray, corner: FloatArray, last: FloatArray, middle: FloatArray, moved: FloatArray) -> float:
    """Return the share of the last points that lie near the first ones after this motion (3,)."""
    c, s = np.cos(moved[2]), np.sin(moved[2])
    points = (last - middle) @ np.array([[c, s], [-s, c]]) + middle + moved[:2]
    index = np.floor((points - corner) / (0.5 * CELL)).astype(int)
    inside = np.all((index >= 0) & (index < near.shape), axis=1)
    return float(near[tuple(index[inside].T)].sum() / len(last))
