"""The tables of ``hopslam bench sim``."""

from collections.abc import Callable
from math import degrees
from typing import Final

from sim.bench.memory import memory_growth
from sim.bench.speed import corridor, env_steps_per_second, reset_times, speed_of
from sim.bench.stall_drives import CASES, drive, scene, sill, sill_outcome
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.pose import Pose2D
from slam.system import peak_memory

SILLS: Final = range(5, 41)
"""Heights of the sills, millimetres."""


def sim_tables(long: bool, console: Terminal) -> list[ResultTable]:
    """Make the tables of the simulator's speed, resets, vector environment and contacts.

    ``long`` adds the memory of many resets and steps.
    """
    parts: list[Callable[[], ResultTable]] = [_speeds, _resets, _vector, _blocked, _sills]
    if long:
        parts.append(_long_life)
    with console.progress(still=True) as bar:
        return [part() for part in bar.track(parts, description="simulator")]


def _speeds() -> ResultTable:
    rows = []
    for caster in ("bullet", "exact"):
        scenario = corridor(caster)
        speed = speed_of(scenario)
        period = scenario.lidar.description.lidar.scan_time
        rows.append(
            (caster, f"{1e6 * speed.engine:.0f}", f"{1e6 * speed.whole:.0f}", f"{100 * speed.ours:.1f} %",
             f"{period / speed.whole:.0f}")
        )  # fmt: skip
    notes = (
        "A corridor with 40 boxes; 682 beams, fired one after the other, with the noise of the paper; 10 scans and 240 "
        "physics steps a second; CPU time. Engine alone: the robot's calls to PyBullet, repeated without the rest; in "
        "the row exact, with its calls to the compiled ray caster. Peak memory: "
        f"{1e-6 * peak_memory():.0f} MB."
    )
    columns = ("caster", "engine alone\nus a scan", "whole\nus a scan", "of which\nours", "simulated s\nper CPU s")
    return ResultTable("Speed of the simulator", columns, rows, notes)


def _resets() -> ResultTable:
    rows = []
    for caster in ("bullet", "exact"):
        same, new = reset_times(corridor(caster))
        rows.append((caster, f"{1e3 * same:.3f}", f"{1e3 * new:.1f}"))
    columns = ("caster", "same world\nms", "new world\nms")
    return ResultTable("Resets", columns, rows, "Median CPU time of restart(), and of making and closing a robot.")


def _vector() -> ResultTable:
    scenario = corridor("bullet")
    one, two = (env_steps_per_second(scenario, processes) for processes in (1, 2))
    rows = [("1", f"{one:.0f}", ""), ("2", f"{two:.0f}", f"{two / one:.2f}")]
    columns = ("processes", "steps/s", "speed-up")
    return ResultTable("Gymnasium's AsyncVectorEnv", columns, rows, "Wall time; each process needs a core of its own.")


def _blocked() -> ResultTable:
    rows = []
    for name, case in CASES.items():
        driven, planned = (drive(scene(**case, physics={"engine": engine})) for engine in ("bullet", "plan"))
        metres, turn = driven.odometry_after_stall
        late = driven.stalled_at - driven.stood_at
        end, other_end = (Pose2D.from_array(made.truth[-1]) for made in (driven, planned))
        rows.append(
            (name, f"{late:.1f}", f"{1e3 * metres:.1f}", f"{degrees(turn):.2f}", f"{1e3 * end.distance(other_end):.0f}",
             f"{abs(degrees(end.between(other_end).theta)):.1f}")
        )  # fmt: skip
    columns = (
        "blocked by", "stalled after\ns", "odometry then\nmm", "heading then\ndeg", "plan ends\nmm away",
        "plan ends\ndeg away",
    )  # fmt: skip
    notes = (
        "The command of 0.3 m/s is held for 10 s more. Stalled after: from standstill to the first scan that reports a "
        "stall. Odometry, heading then: how far the odometry moves and turns after that scan. Last columns: from the "
        "final pose with PyBullet to that with physics.engine: plan."
    )
    return ResultTable("A blocked base", columns, rows, notes)


def _sills() -> ResultTable:
    outcomes = {height: sill_outcome(scene(sill(height / 1000.0))) for height in SILLS}
    rows = []
    for outcome in ("over", "stopped", "hung"):
        heights = [height for height in SILLS if outcomes[height] == outcome]
        span = f"{heights[0]} to {heights[-1]}" if heights else "none"
        rows.append((outcome, str(len(heights)), span))
    return ResultTable("Sills at 0.3 m/s", ("", "sills", "mm"), rows)


def _long_life() -> ResultTable:
    growth = memory_growth(corridor("bullet"), resets=10_000, scans_each=5, robots=1000)
    rows = [
        (f"{growth.resets:,} resets, {growth.steps:,} physics steps", f"{growth.of_one_robot:.1f}"),
        (f"{growth.robots:,} robots made and closed", f"{growth.of_many_robots:.1f}"),
    ]
    return ResultTable("Growth of memory", ("", "MB"), rows, "Growth of the peak memory of the process.")
