"""The tables of ``hopslam bench hardware``."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import degrees
from typing import Final

import numpy as np

from hardware.bench.driven_path import DrivenPath, PathDifference
from hardware.bench.emulated_robot import emulated_robot, measure_load
from hardware.bench.endings import ENDINGS, EndingResult, ending_result
from hardware.bench.faults import CUT_OFF, FAULTS, FaultResult, fault_results, kill_result
from hardware.bench.noise import RECEIVERS, ByteDamage, ReceptionCounts
from hardware.bench.sim_comparison import drive_emulated, drive_env_emulated, drive_env_simulated, drive_simulated
from slam.console.result_table import ResultTable
from slam.console.terminal import Terminal
from slam.run.backends import PLANTS
from slam.scenario.file import load_scenario

_DAMAGES: Final = {
    "1 % of bytes, anywhere": ByteDamage(0.01),
    "1 % of bytes, in runs of 64": ByteDamage(0.01, 64),
    "a bit in 1 % of bytes": ByteDamage(0.01, bits=True),
    "0.1 % of bytes, anywhere": ByteDamage(0.001),
    "a bit in 0.1 % of bytes": ByteDamage(0.001, bits=True),
}
_QUIET: Final = ("lidar.noise=none", "robot.odometry.travel_noise=0")
_GOAL: Final = (10.0, 0.0)
"""Goal of the policy in the environment: x, y in the map frame, metres."""
_PATH_COLUMNS: Final = ("largest\ncm", "distance to sim\nrms, cm", "largest\ncm", "heading\ndeg")
_WATCHDOGS: Final = (2.0, 0.4)
"""Watchdogs, seconds: the factory setting, and the one that docs/hardware.md recommends."""


def load_table(seconds: float, console: Terminal, settings: Sequence[str] = ()) -> ResultTable:
    """Measure the processor time of drivers and emulator, and the delay of scans."""
    with console.progress(transient=True, still=True) as bar, emulated_robot(settings=settings) as emulated:
        bar.add_task(f"driving for {seconds:g} s", total=None)
        bar.refresh()
        load = measure_load(emulated, seconds)
    return ResultTable(
        "Drivers and emulator, in real time",
        ("", "value"),
        [
            ("CPU of one core, drivers and emulator together", f"{100.0 * load.cpu:.1f} %"),
            ("scans a second", f"{load.scans / load.seconds:.2f}"),
            ("from last beam to observe, median", f"{1e3 * load.latency_median:.1f} ms"),
            ("from last beam to observe, p99", f"{1e3 * load.latency_p99:.1f} ms"),
        ],
        f"The corridor at 0.3 m/s for {seconds:g} s, moved by PyBullet, over two pseudo-terminals.",
    )


def fault_table(console: Terminal, settings: Sequence[str] = ()) -> ResultTable:
    """Measure every fault; faults that cut the robot off are measured with both watchdogs."""
    total = len(FAULTS) + len(_WATCHDOGS) * (len(CUT_OFF) + 1)
    with console.progress(still=True) as bar:
        rows = [_fault_row(*found) for found in bar.track(_faults(settings), total, description="faults")]
    columns = ("fault", "until at rest\ns", "stopped by", "end of fault\nto motion, s", "reason named")
    notes = (
        "The watchdog brakes the robot when no command has arrived for its time. The last command arrived up to 0.1 s "
        "before the fault."
    )
    return ResultTable("Faults at 0.3 m/s", columns, rows, notes)


def _faults(settings: Sequence[str]) -> Iterator[tuple[FaultResult, str]]:
    """Yield each fault's result, and the condition under which it was measured."""
    conditions = {watchdog: f", watchdog {watchdog:g} s" for watchdog in _WATCHDOGS}
    # these fork programs to kill them, so they run before any thread starts
    yield from [(kill_result(watchdog, settings), condition) for watchdog, condition in conditions.items()]
    yield from ((result, "") for result in fault_results(FAULTS, _WATCHDOGS[0], settings))
    for watchdog, condition in conditions.items():
        yield from ((result, condition) for result in fault_results(CUT_OFF, watchdog, settings))


def ending_table(console: Terminal) -> ResultTable:
    """Measure every way in which a program can end, with both plants."""
    results = ((plant, ending_result(ending, plant)) for plant in PLANTS for ending in ENDINGS)
    with console.progress(still=True) as bar:
        total = len(PLANTS) * len(ENDINGS)
        rows = [_end_row(*found) for found in bar.track(results, total, description="endings")]
    columns = ("a program's end", "plant", "stop command\ns", "at rest\ns", "distance\ncm", "exit code", "metrics.json")
    notes = "No program can see SIGKILL and SIGSTOP: there the robot's watchdog stops it, as in the table of faults."
    return ResultTable("A program ends at 0.3 m/s", columns, rows, notes)


def noise_table(packets: int, console: Terminal) -> ResultTable:
    """Measure which messages get through a noisy wire."""
    messages = [(name, receive, *damage) for name, receive in RECEIVERS.items() for damage in _DAMAGES.items()]
    with console.progress(still=True) as bar:
        rows = [
            _noise_row(name, kind, receive(packets, damage))
            for name, receive, kind, damage in bar.track(messages, description="noise")
        ]
    columns = ("", "damage", "sent", "not hit", "of these\nreceived %", "accepted\nwrong", "ranges\nkept %")
    notes = "For scans, wrong ranges are counted. Kept: share of all ranges of all scans that were received correctly."
    return ResultTable("A noisy wire", columns, rows, notes)


def sim_table(
    scenario: str, settings: Sequence[str], console: Terminal, allow_modules: Sequence[str] = ()
) -> ResultTable:
    """Compare a scenario, simulated and on emulated devices, without noise and with the noise of two seeds."""
    load = partial(load_scenario, scenario, allow_modules=allow_modules)
    quiet, other = [*settings, *_QUIET], [*settings, f"seed={load(settings).seed + 1000}"]
    calm, noisy = drive_simulated(load, quiet, console), drive_simulated(load, settings, console)
    rows = [
        _sim_row("no noise: sim", calm, None),
        _sim_row("no noise: hardware", drive_emulated(load, quiet, console), calm),
        _sim_row("noise: sim", noisy, None),
        _sim_row("noise: sim, another seed", drive_simulated(load, other, console), noisy),
        _sim_row("noise: hardware", drive_emulated(load, settings, console), noisy),
    ]
    columns = ("", "SLAM error\nrms, cm", *_PATH_COLUMNS, "at way-points\ncm")
    notes = (
        "The true path is compared with that of sim, at the same points along the route. The robot steers by SLAM, "
        "whose errors come from noise, which differs in every run: another seed shows the effect of noise alone."
    )
    return ResultTable(f"{scenario}, simulated and on emulated devices", columns, rows, notes)


def env_table(scenario: str, settings: Sequence[str], allow_modules: Sequence[str] = ()) -> ResultTable:
    """Compare a policy in the environment, simulated and on emulated devices, from the start to ``_GOAL``."""
    load = partial(load_scenario, scenario, allow_modules=allow_modules)
    simulated = drive_env_simulated(load, settings, _GOAL)
    paths = {f"hardware, plant {plant}": drive_env_emulated(load, settings, _GOAL, plant) for plant in PLANTS}
    columns = ("", "pose error\nrms, cm", *_PATH_COLUMNS, "at rest\ncm")
    rows = [_env_row("sim", simulated, simulated), *(_env_row(name, path, simulated) for name, path in paths.items())]
    notes = (
        "True paths. In the simulator the policy gets the true direction of the goal; on devices, that of SLAM. "
        "The plant named plan has neither noise nor wheel errors. At rest: distance between the final positions."
    )
    return ResultTable(
        f"{scenario} in the environment, to x = 10 m, simulated and on emulated devices", columns, rows, notes
    )


def _env_row(name: str, path: DrivenPath, simulated: DrivenPath) -> tuple[str, ...]:
    if path is simulated:
        return _sim_row(name, path, None)
    rest = np.hypot(*(path.truth[-1] - simulated.truth[-1])[:2])
    return (*_sim_row(name, path, simulated)[:-1], *_centimetres(rest))


def _sim_row(name: str, path: DrivenPath, simulated: DrivenPath | None) -> tuple[str, ...]:
    own = _centimetres(np.sqrt(np.mean(path.errors**2)), path.errors.max())
    if simulated is None:
        return (name, *own, "", "", "", "")
    apart = PathDifference.between(simulated.truth, path.truth)
    rms, largest, ends = _centimetres(apart.rms, apart.largest, apart.ends)
    return (name, *own, rms, largest, f"{degrees(apart.heading):.2f}", ends)


def _fault_row(result: FaultResult, condition: str) -> tuple[str, ...]:
    stands, drives = _seconds(result.to_stand), _seconds(result.to_drive)
    return result.name + condition, stands, result.stopped_by, drives, result.reason


def _end_row(plant: str, result: EndingResult) -> tuple[str, ...]:
    code = "goes on" if result.exit_code is None else str(result.exit_code)
    times = (_seconds(result.to_command), _seconds(result.to_stand), *_centimetres(result.distance))
    return result.name, plant, *times, code, "yes" if result.recorded else "no"


def _noise_row(name: str, damage: str, counts: ReceptionCounts) -> tuple[str, ...]:
    received = f"{100.0 * counts.received / counts.unharmed:.1f}" if counts.unharmed else ""
    kept = f"{100.0 * counts.beams:.1f}" if name == "scans" else ""
    return name, damage, f"{counts.sent:,}", f"{counts.unharmed:,}", received, str(counts.wrong), kept


def _centimetres(*metres: float) -> list[str]:
    return [f"{100.0 * value:.1f}" for value in metres]


def _seconds(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.2f}"
